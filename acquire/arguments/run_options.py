"""Options of every command that moves an arm: controller, stop limits, payload."""

import sys
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.drivers.errors import BadSettings
from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects import known_parameters
from exidyn.identification.errors import NeedsPayload, RobotError
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.robot_files.toml_fields import parse_toml
from exidyn.trajectories.plans.plan_summary import LONG, duration_words

from ..run.errors import NotAllowed
from ..run.stopping.watch import WatchLimits
from .command import Option, positive, valid_if
from .options import seed_option
from .parser import complaint

PAYLOAD = "L"
"""Name of the payload, which also begins the names of its unknown parameters."""
HOTTEST_WINDING = 180.0
"""Largest temperature of a motor winding, insulation class H of IEC 60085 [degC]; few have a higher class."""
SEEN_IN = 0.5
"""Time within which a joint that runs away at its velocity limit must exceed its tracking tolerance [s]:
a later stop would come after a collision."""
LONGEST = 3600.0
"""Duration above which a person has to confirm that the run is intended [s]: an arm is warm within an hour,
and ten minutes identify it."""

motor_temperature = valid_if(
    lambda value: value <= HOTTEST_WINDING,
    f"degC: no winding withstands more than {HOTTEST_WINDING:g} (insulation class H)",
    positive,
)
PLANT_HELP = "true arm of the mock; default: ROBOT, for record with each value off by up to its tolerance"
CONTROLLER = (
    Option("--driver DRIVER", "default: the driver of the controller file, or mock"),
    Option("--controller FILE", "driver and settings (.toml), as 'exidyn init --driver DRIVER' prints", Path),
    Option("--set NAME=VALUE", "one setting, overrides the file; may be repeated", str, [], repeated=True),
)
DRIVING = (
    *CONTROLLER,
    Option("--plant ROBOT", PLANT_HELP),
    seed_option("seed of the mock's noise"),
    Option("--yes", "do not ask for confirmation; docs/record.md states when that is allowed"),
)
STOPS = (
    Option("--tracking DEG", "largest deviation from the command", positive, 2.0),
    Option("--current A...", "one value, or one per joint; default: from the torque limits", positive),
    Option("--temperature DEGC", "largest motor temperature", motor_temperature, 85.0),
)


def require_mock(args: Namespace, driver: str) -> None:
    """Raise `NotAllowed` if --plant comes with a driver of a real arm."""
    if args.plant and driver != "mock":
        raise NotAllowed(
            f"--plant is the true arm of the mock, but driver {driver} moves a real arm. Omit one of them"
        )


def run_facts(args: Namespace, driver: str, path: Path, **more: str) -> dict[str, str]:
    """Facts that a person should know before confirming, name -> text."""
    payload = f"{args.mass:g} kg" if args.mass else "nothing"
    return {"controller": driver, **more, "on the flange": payload, "recorded to": str(path)}


def check_duration(planned: float, speed: float, confirmed: bool) -> None:
    """Print the duration of a run of over a minute, and refuse more than an hour unless confirmed (--long).

    `planned` is the duration of the motion [s], which is played at a share `speed` of its speed [-].

    Raises:
        NotAllowed: If the run is longer than `LONGEST` and not confirmed.
    """
    seconds = planned / speed
    words = f"the run takes {duration_words(seconds)} at {100 * speed:g} % of the planned speed"
    if seconds > LONGEST and not confirmed:
        raise NotAllowed(
            f"{words}; confirm a run of more than {LONGEST / 3600:g} h with --long, or increase --speed"
        )
    if seconds >= LONG:
        print(complaint(f"exidyn: {words}; checking it"), file=sys.stderr)


def stop_limits(args: Namespace, robot: Robot) -> tuple[WatchLimits, np.ndarray | None]:
    """Limits of the monitors, and each joint's largest current, shape (n,) [A]; None without --current.

    Raises:
        NotAllowed: If the tracking tolerance is too large for a stop to act in time, or the number of
            currents is neither 1 nor the number of joints.
    """
    tracking = float(np.radians(args.tracking))
    largest, joint = _largest_tracking(robot)
    if tracking > largest:
        raise NotAllowed(
            f"--tracking is {np.degrees(tracking):g} degrees; with more than "
            f"{np.floor(np.degrees(largest)):g} degrees no stop of {joint} could act in time (half its range "
            f"or {SEEN_IN:g} s at its velocity limit). Reduce it, or find out why the arm lags its command"
        )
    watch = WatchLimits(tracking=tracking, temperature=args.temperature)
    if not args.current:
        return watch, None
    if len(args.current) not in (1, robot.dof):
        raise NotAllowed(
            f"--current has {len(args.current)} values; expected 1 value, or 1 per joint ({robot.dof})"
        )
    return watch, np.broadcast_to(np.array(args.current), (robot.dof,))


def _largest_tracking(robot: Robot) -> tuple[float, str]:
    """Largest tracking tolerance with which a stop can still act in time [rad], and the joint that sets it.

    It is half a joint's range or the distance at its velocity limit in half a second, whichever is less.
    """
    limits = robot.limits
    half = 0.5 * (limits.position_upper - limits.position_lower)
    distance = SEEN_IN * np.maximum(limits.velocity, -limits.velocity_lower)
    largest = np.where(robot.revolute, np.minimum(half, distance), np.inf)
    joint = int(np.argmin(largest))
    return float(largest[joint]), robot.joints[joint]


def payload_of(args: Namespace) -> KnownPayload | None:
    """The payload that --mass, --com and --inertia describe; None without them.

    Raises:
        NeedsPayload: If --com or --inertia come without --mass.
    """
    numbers = {n: getattr(args, n) for n in ("mass", "com", "inertia") if getattr(args, n) is not None}
    known = known_body(numbers)
    return KnownPayload(PAYLOAD, known) if known else None


def known_body(numbers: Mapping[str, Any], where: str = "") -> tuple[tuple[str, float], ...]:
    """Known parameters of a payload from keyword arguments of `known_parameters`; empty without numbers.

    Raises:
        NeedsPayload: If a center of mass or an inertia comes without a mass; the message begins with `where`.
    """
    if numbers and "mass" not in numbers:
        raise NeedsPayload(f"{where}{' and '.join(numbers)} given without --mass [kg]")
    return known_parameters(**numbers) if numbers else ()


KEYS = {"driver": (str, 'a text, such as driver = "mock"'), "settings": (dict, "a table, [settings]")}
"""Key of a controller file -> its type, and a description of the type."""


def read_controller(
    path: Path | None, name: str | None, assignments: Sequence[str]
) -> tuple[str, dict[str, Any]]:
    """Name and settings of a driver, by default the mock: those of a file, overridden by "name=value" texts.

    Raises:
        BadSettings: If the file is not a controller file, or an assignment is not of the form name=value.
    """
    table = _file(path) if path else {}
    file_driver = table.get("driver", "")
    if name and file_driver and name != file_driver:
        raise BadSettings(f"--driver {name}, but {path} is for {file_driver}. Omit one of them")
    settings = dict(table.get("settings", {}))
    for text in assignments:
        key, equals, value = text.partition("=")
        if not equals:
            raise BadSettings(f"--set {text}: expected NAME=VALUE, such as --set cycle=0.004")
        settings[key.strip()] = _value(value.strip())
    return name or file_driver or "mock", settings


def _file(path: Path) -> Mapping[str, Any]:
    try:
        table = parse_toml(path.read_text(encoding="utf-8"), "not a controller file")
    except (UnicodeDecodeError, RobotError) as error:
        raise BadSettings(f"{path}: {error}") from error
    unknown = [key for key in table if key not in KEYS]
    if unknown:
        raise BadSettings(
            f"{path}: unknown key '{unknown[0]}'. Valid: {', '.join(KEYS)}; all settings of a driver are "
            "below [settings]"
        )
    for key, (kind, form) in KEYS.items():
        if not isinstance(table.get(key, kind()), kind):
            raise BadSettings(f"{path}: {key} is {table[key]!r}; expected {form}")
    return table


def _value(text: str) -> Any:
    """The TOML value of a text, or the text itself if it is not a TOML value."""
    try:
        return parse_toml(f"value = {text}", "--set")["value"]
    except RobotError:
        return text
