"""Units of a log that its user states, for a proposal: they are certain, and the others are weighed."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ..arm.robot import Robot
from ..errors import WrongShape
from ..recordings.recording import EFFORT, SIGNALS
from ..recordings.tables.preset import Reading
from ..recordings.units import COMMANDS, factors
from .imported_log import Log
from .suspicion import Guess
from .units import Units

Stated = Mapping[str, list[str]]
"""`time` or a signal -> unit of each joint; a single one for the time."""
DEGREES = "degrees"
"""Key for degrees of revolute joints alone."""
RADIANS = ("position", "velocity", DEGREES)
"""Keys that `--degrees` states, whether or not the log has such columns."""


def stated_by(units: Mapping[str, str | Sequence[str]], degrees: bool, robot: Robot) -> dict[str, list[str]]:
    """Units by signal, one per joint, from options like those of import.

    Raises:
        WrongShape: A signal is unknown, or there is not one unit per joint.
    """
    stated: dict[str, list[str]] = {}
    if degrees and not robot.revolute.all():
        stated = {DEGREES: []}  # prismatic joints may be in millimeters
    elif degrees:
        stated = {"position": ["deg"] * robot.dof, "velocity": ["deg/s"] * robot.dof}
    for signal, unit in units.items():
        if signal not in ("time", "effort", *SIGNALS):
            valid = ", ".join(("time", *SIGNALS, "effort"))
            raise WrongShape(f"units (--units): unknown {signal}. Valid: {valid}")
        count = 1 if signal == "time" else robot.dof
        stated[signal] = [unit] * count if isinstance(unit, str) else list(unit)
        if len(stated[signal]) != count:
            raise WrongShape(f"units (--units): {signal} has {len(unit)} units, but there are {count} joints")
    return stated


def unit_of_signal(stated: Stated, signal: str) -> list[str] | None:
    """Stated unit of a signal; a command without one has that of the measured signal."""
    if signal in EFFORT:
        return stated.get(signal, stated.get("effort"))
    return stated.get(signal, stated.get(COMMANDS.get(signal, "")))


def fixed_units(stated: Stated, robot: Robot) -> Units:
    """Units of a log in which what is stated was converted to SI, "" for what is not stated."""
    si = "rad" if robot.revolute.any() else "m"
    known = {"time": "s", "position": si, "velocity": si}
    units = Units(*(unit * (name in stated) for name, unit in known.items()))
    return units._replace(position=units.position or "deg" * (DEGREES in stated))


def in_si(log: Log, stated: Stated, robot: Robot) -> Log:
    """Log in which signals of a stated unit are in SI."""
    values = dict(log.values)
    for signal in values:
        if (unit := unit_of_signal(stated, signal)) is not None and signal not in EFFORT:
            factor, offset = factors(robot.units(SIGNALS[signal]), unit, _option(signal), robot.limits)
            values[signal] = values[signal] * factor + offset
    [scale] = factors(["s"], stated.get("time", ["s"]), _option("time"))[0].tolist()
    return Log(log.time * scale, values)


def _option(signal: str) -> str:
    return f"units (--units): {signal}"


def with_stated(readings: Mapping[str, Reading], stated: Stated) -> dict[str, Reading]:
    """Readings of signals in which stated units replace those of a hypothesis."""
    return {
        signal: reading
        if (unit := unit_of_signal(stated, signal)) is None
        else Reading(reading.column, unit[0] if len(set(unit)) == 1 else unit, reading.sign)
        for signal, reading in readings.items()
    }


def as_stated(guess: Guess, stated: Stated) -> Guess:
    """A guess of a unit, which is certain if it is stated."""
    asked, _, signal = guess.what.partition("unit of ")
    unit = None if asked else stated.get(signal)
    if not unit:
        return guess
    return replace(guess, value=", ".join(dict.fromkeys(unit)), probability=1.0, why="as stated")


def permuted(stated: Stated, order: Sequence[int]) -> dict[str, list[str]]:
    """Stated units in the robot's order of joints, if column `order[j]` is that of joint j."""
    return {s: [unit[k] for k in order] if len(unit) == len(order) else unit for s, unit in stated.items()}


def require_used(stated: Stated, signals: Sequence[str]) -> None:
    """Refuse units of signals that a log does not have."""
    known = {*signals, "time", *(("effort",) if {*EFFORT} & {*signals} else ())}
    if missing := [signal for signal in stated if signal not in known and signal not in RADIANS]:
        raise WrongShape(f"units (--units): the log has no {', '.join(missing)}; it has {', '.join(signals)}")
