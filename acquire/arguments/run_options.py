"""Options of every command that moves an arm: what stops the run, and what hangs on the flange."""

import argparse
from pathlib import Path

import numpy as np

from exidyn.identify.arm.robot import Robot
from exidyn.identify.effects import known_parameters
from exidyn.identify.errors import NeedsPayload
from exidyn.identify.recordings.recording import KnownPayload

from ..run.errors import NotAllowed
from ..run.stopping.watch import WatchLimits
from .common import add_seed, positive
from .controllers import add_controller

BODY = "L"
"""What the unknown parameters of the payload are called after."""
PLANT_HELP = "what the mock's arm really is; default: ROBOT, in record each value off by up to its tolerance"


HOTTEST_WINDING = 180.0
"""What the insulation of a motor's winding bears, class H of IEC 60085 [degC]; few have a higher one."""


def motor_temperature(text: str) -> float:
    """A temperature at which a motor can still be stopped in time [degC]."""
    value = positive(text)
    if value > HOTTEST_WINDING:
        raise argparse.ArgumentTypeError(
            f"{text} degC: no winding bears more than {HOTTEST_WINDING:g} (insulation class H)"
        )
    return value


def add_stops(group: argparse._ArgumentGroup) -> None:
    """Add --tracking, --current and --temperature."""
    group.add_argument(
        "--tracking", type=positive, default=2.0, metavar="DEG", help="away from the command; default: 2"
    )
    group.add_argument(
        "--current",
        type=positive,
        nargs="+",
        metavar="A",
        help="one, or one a joint; default: by the torque limits",
    )
    group.add_argument(
        "--temperature", type=motor_temperature, default=85.0, metavar="DEGC", help="default: 85"
    )


def add_driving(group: argparse._ArgumentGroup) -> None:
    """Add --driver, --controller, --set, --plant, --seed and --yes."""
    add_controller(group)
    group.add_argument("--plant", metavar="ROBOT", help=PLANT_HELP)
    add_seed(group, "of the mock's noise")
    group.add_argument(
        "--yes", action="store_true", help="do not ask; see docs/record.md for when that is allowed"
    )


def require_mock(given: argparse.Namespace, driver: str) -> None:
    """Raise where another arm is given for a driver that moves a real one.

    Raises:
        NotAllowed: It is.
    """
    if given.plant and driver != "mock":
        raise NotAllowed(
            f"--plant is an arm of the mock, and {driver} moves a real one. Leave one of them out"
        )


def facts_of(given: argparse.Namespace, driver: str, path: Path, **more: str) -> dict[str, str]:
    """What a person should know before confirming, by name."""
    carried = f"{given.mass:g} kg" if given.mass else "nothing"
    return {"controller": driver, **more, "on the flange": carried, "recorded to": str(path)}


SEEN_IN = 0.5
"""Time within which a joint that runs away at its velocity limit must be beyond its tracking tolerance [s]:
what goes unseen for longer is stopped when it has hit something."""


def largest_tracking(robot: Robot) -> tuple[float, str]:
    """Largest tracking tolerance in which a stop can still act in time [rad], and the joint that sets it.

    Half a joint's range, or the way at its velocity limit in half a second, whichever is less.
    """
    limits = robot.limits
    half = 0.5 * (limits.position_upper - limits.position_lower)
    way = SEEN_IN * np.maximum(limits.velocity, -limits.velocity_lower)
    largest = np.where(robot.revolute, np.minimum(half, way), np.inf)
    joint = int(np.argmin(largest))
    return float(largest[joint]), robot.joints[joint]


def _require_tracking(tracking: float, robot: Robot) -> None:
    largest, joint = largest_tracking(robot)
    if tracking > largest:
        raise NotAllowed(
            f"--tracking {np.degrees(tracking):g}: with more than {np.floor(np.degrees(largest)):g} degrees "
            f"no stop of {joint} could act in time (half its range, or {SEEN_IN:g} s at its velocity limit). "
            "Give less, or look why the arm stays behind"
        )


def stops_of(given: argparse.Namespace, robot: Robot) -> tuple[WatchLimits, np.ndarray | None]:
    """Limits of the monitors, and the largest current of each joint, shape (n,) [A], where one is given.

    Raises:
        NotAllowed: A tracking tolerance in which no stop acts in time; neither one current, nor one a joint.
    """
    tracking = float(np.radians(given.tracking))
    _require_tracking(tracking, robot)
    watch = WatchLimits(tracking=tracking, temperature=given.temperature)
    if not given.current:
        return watch, None
    if len(given.current) not in (1, robot.dof):
        raise NotAllowed(
            f"--current has {len(given.current)} values; expected one, or one for each of the "
            f"{robot.dof} joints"
        )
    return watch, np.broadcast_to(np.array(given.current), (robot.dof,))


def body_of(given: argparse.Namespace) -> KnownPayload | None:
    """The body on the flange that --mass, --com and --inertia describe; None without them.

    Raises:
        NeedsPayload: One of the others without --mass.
    """
    numbers = {n: getattr(given, n) for n in ("mass", "com", "inertia") if getattr(given, n) is not None}
    if not numbers:
        return None
    if "mass" not in numbers:
        raise NeedsPayload(f"{' and '.join(numbers)} given without --mass [kg]")
    return KnownPayload(BODY, known_parameters(**numbers))
