"""Options of every command that moves an arm: its controller, what stops the run, what is on the flange."""

import sys
from argparse import Namespace
from pathlib import Path

import numpy as np

from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects import known_parameters
from exidyn.identification.errors import NeedsPayload
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.trajectories.plans.plan_summary import LONG, duration_words

from ..run.errors import NotAllowed
from ..run.stopping.watch import WatchLimits
from .command import Option, positive, valid_if
from .controllers import CONTROLLER
from .options import seed_option
from .parser import complaint

PAYLOAD = "L"
"""What a body on the flange is called, and its unknown parameters after it."""
HOTTEST_WINDING = 180.0
"""What the insulation of a motor's winding bears, class H of IEC 60085 [degC]; few have a higher one."""
SEEN_IN = 0.5
"""Time within which a joint that runs away at its velocity limit must be beyond its tracking tolerance [s]:
what goes unseen for longer is stopped when it has hit something."""
LONGEST = 3600.0
"""Duration of a run beyond which a person has to confirm that it is meant [s]: an arm is warm within an hour,
and ten minutes identify it."""

motor_temperature = valid_if(
    lambda value: value <= HOTTEST_WINDING,
    f"degC: no winding bears more than {HOTTEST_WINDING:g} (insulation class H)",
    positive,
)
PLANT_HELP = "what the mock's arm really is; default: ROBOT, in record each value off by up to its tolerance"
DRIVING = (
    *CONTROLLER,
    Option("--plant ROBOT", PLANT_HELP),
    seed_option("of the mock's noise"),
    Option("--yes", "do not ask; see docs/record.md for when that is allowed"),
)
STOPS = (
    Option("--tracking DEG", "away from the command", positive, 2.0),
    Option("--current A...", "one, or one a joint; default: by the torque limits", positive),
    Option("--temperature DEGC", "", motor_temperature, 85.0),
)


def require_mock(given: Namespace, driver: str) -> None:
    """Raise where another arm is given for a driver that moves a real one.

    Raises:
        NotAllowed: It is.
    """
    if given.plant and driver != "mock":
        raise NotAllowed(
            f"--plant is an arm of the mock, and {driver} moves a real one. Leave one of them out"
        )


def facts_of(given: Namespace, driver: str, path: Path, **more: str) -> dict[str, str]:
    """What a person should know before confirming, by name."""
    carried = f"{given.mass:g} kg" if given.mass else "nothing"
    return {"controller": driver, **more, "on the flange": carried, "recorded to": str(path)}


def check_length(planned: float, speed: float, confirmed: bool) -> None:
    """State how long a run takes if that is more than a minute, and refuse one beyond an hour.

    Args:
        planned: Duration of the motion as it was planned [s].
        speed: Share of the planned speed [-].
        confirmed: Whether a longer run is meant (--long).

    Raises:
        NotAllowed: It is longer, and not confirmed.
    """
    seconds = planned / speed
    words = f"the run takes {duration_words(seconds)} at {100 * speed:g} % of the planned speed"
    if seconds > LONGEST and not confirmed:
        raise NotAllowed(
            f"{words}; confirm a run of more than {LONGEST / 3600:g} h by --long, or give another --speed"
        )
    if seconds >= LONG:
        print(complaint(f"exidyn: {words}; checking it"), file=sys.stderr)


def stops_of(given: Namespace, robot: Robot) -> tuple[WatchLimits, np.ndarray | None]:
    """Limits of the monitors, and the largest current of each joint, shape (n,) [A], where one is given.

    Raises:
        NotAllowed: A tracking tolerance in which no stop acts in time; neither one current, nor one a joint.
    """
    tracking = float(np.radians(given.tracking))
    largest, joint = _largest_tracking(robot)
    if tracking > largest:
        raise NotAllowed(
            f"--tracking {np.degrees(tracking):g}: with more than {np.floor(np.degrees(largest)):g} degrees "
            f"no stop of {joint} could act in time (half its range, or {SEEN_IN:g} s at its velocity limit). "
            "Give less, or look why the arm stays behind"
        )
    watch = WatchLimits(tracking=tracking, temperature=given.temperature)
    if not given.current:
        return watch, None
    if len(given.current) not in (1, robot.dof):
        raise NotAllowed(
            f"--current has {len(given.current)} values; expected one, or one for each of the "
            f"{robot.dof} joints"
        )
    return watch, np.broadcast_to(np.array(given.current), (robot.dof,))


def _largest_tracking(robot: Robot) -> tuple[float, str]:
    """Largest tracking tolerance in which a stop can still act in time [rad], and the joint that sets it.

    Half a joint's range, or the way at its velocity limit in half a second, whichever is less.
    """
    limits = robot.limits
    half = 0.5 * (limits.position_upper - limits.position_lower)
    way = SEEN_IN * np.maximum(limits.velocity, -limits.velocity_lower)
    largest = np.where(robot.revolute, np.minimum(half, way), np.inf)
    joint = int(np.argmin(largest))
    return float(largest[joint]), robot.joints[joint]


def body_of(given: Namespace) -> KnownPayload | None:
    """The body on the flange that --mass, --com and --inertia describe; None without them.

    Raises:
        NeedsPayload: One of the others without --mass.
    """
    numbers = {n: getattr(given, n) for n in ("mass", "com", "inertia") if getattr(given, n) is not None}
    if not numbers:
        return None
    if "mass" not in numbers:
        raise NeedsPayload(f"{' and '.join(numbers)} given without --mass [kg]")
    return KnownPayload(PAYLOAD, known_parameters(**numbers))
