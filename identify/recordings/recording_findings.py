"""What cannot be in a recording: numbers, times and units that no arm has."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..errors import BadTime, BadUnit, NotFinite, RecordingError
from .recording import EFFORT, Recording, Signal
from .steps_back import advice, steps_back
from .wrong_unit import MILLIMETRES, angle_advice

SLOWEST = 0.5
"""Longest median period of positions or currents [s]. An arm's motion cannot be followed at 2 Hz, but any
usual rate given in milliseconds (500 Hz: 2.0) is above."""

TURNS_WITH_LIMITS = 4 * np.pi
"""Position that a limited joint cannot reach [rad]: two turns each way, twice what wrists of common arms do.
Where the robot's own limit is higher, half as much again counts instead."""

TURNS_WITHOUT_LIMITS = 20 * np.pi
"""Position of an endless joint that is rather taken for degrees [rad]: ten turns, never unwound."""

LONGEST_SLIDE = 100.0
"""Position that no sliding joint can have [m]; the same number in millimetres would be a short axis."""

FASTEST_TURN = 20.0
"""Speed that no joint of an arm keeps up [rad/s], where its robot file allows no higher one: twice that of
the fastest small arms' wrists."""
SPAN = 0.1
"""Time over which a speed is taken, if samples come more often [s]."""
BEYOND_LIMIT = 1.5
"""Over the limit of the robot file: what moves faster does not exceed its limit, it is in another unit."""

FAR_BEYOND_TORQUE = 20.0
"""Over the torque limit of the robot file, in a twentieth of the samples: a drive gives a few times its limit
for moments. In mA, a joint that uses a fiftieth of its limit is above."""

HOTTEST = 200.0
"""Temperature that no motor survives [degC]; in kelvin every motor is above."""

LARGEST = 1e15
"""Number that no signal of an arm has in any unit, and whose square is still a number."""

LONGEST = 1e9
"""Time since its start that no run lasts [s]; nanoseconds of nine times as much do not fit into 64 bits."""


class Finding(NamedTuple):
    """Something that cannot be.

    Attributes:
        kind: Error that it is in a file from elsewhere.
        fact: What was found, and which limit it exceeds.
        advice: What to do about such a file.
        time: When the first sample concerned was taken [s]; None if there is no such sample.
    """

    kind: type[RecordingError]
    fact: str
    advice: str
    time: float | None = None

    def error(self, name: str) -> RecordingError:
        """The error, of the recording of that name."""
        text = f"{name}: {self.fact}. {self.advice}"
        return NotFinite(text, self.time) if self.kind is NotFinite else self.kind(text)


def findings(recording: Recording) -> Iterator[Finding]:
    """All that cannot be, signal by signal."""
    for name, signal in recording.signals.items():
        if len(signal):
            yield from _not_finite(recording, name, signal)
            yield from _bad_time(name, signal)
    if len(recording.signals["position"]):
        yield from _turns(recording)
        yield from _speed(recording)
    yield from _torque(recording)
    yield from _temperature(recording)


def finite(column: np.ndarray) -> np.ndarray:
    """Those values of a column that are numbers."""
    return column[is_number(column)]


def is_number(values: np.ndarray) -> np.ndarray:
    """Which values are numbers that can be computed with, bool of the same shape."""
    return np.abs(values) < LARGEST  # false for NaN and infinity


def _not_finite(recording: Recording, name: str, signal: Signal) -> Iterator[Finding]:
    advice = "Leave such samples out; time stamps need not be regular"
    if not np.all(np.abs(signal.time) < LONGEST):
        bad = (~(np.abs(signal.time) < LONGEST)).sum()
        yield Finding(
            NotFinite, f"time of {name} is not finite, or above {LONGEST:g} s, in {bad} samples", advice
        )
    optional = name not in ("position", *EFFORT)
    for joint, column in zip(recording.robot.joints, signal.values.T, strict=True):
        bad = ~is_number(column)
        if len(bad) and np.isnan(column).all() and not optional:
            yield Finding(
                NotFinite,
                f"{name} of {joint} is empty: no sample has a number",
                "Record it, or name its column; a joint without motor is [drive] passive in robot.toml",
            )
        elif bad.any() and not (optional and np.isnan(column).all()):
            first = float(signal.time[bad.argmax()])
            what = f"above {LARGEST:g}" if np.isfinite(column).all() else "not finite"
            yield Finding(
                NotFinite,
                f"{name} of {joint} is {what} in {bad.sum()} of {len(bad)} samples, first at {first:.3f} s",
                advice,
                first if np.isfinite(first) else None,
            )


def _bad_time(name: str, signal: Signal) -> Iterator[Finding]:
    back = steps_back(signal.time)
    if len(back):
        first = back[0]
        yield Finding(
            BadTime,
            f"time of {name} does not increase at {len(back)} of {len(signal) - 1} steps, first "
            f"from {signal.time[first]:.6f} s to {signal.time[first + 1]:.6f} s",
            advice(signal.time, signal.values),
        )
    if name in ("position", *EFFORT) and signal.period > SLOWEST:
        yield Finding(
            BadUnit,
            f"{name} comes every {signal.period:g} s, at most {SLOWEST} s can be followed",
            f"In milliseconds that would be {1e3 / signal.period:g} Hz: import with time_scale=0.001 "
            "(--time-scale 0.001)",
        )


def _turns(recording: Recording) -> Iterator[Finding]:
    limits, revolute = recording.robot.limits, recording.robot.revolute
    reach = np.maximum(np.abs(limits.position_lower), np.abs(limits.position_upper))
    turns = np.where(np.isfinite(reach), np.maximum(TURNS_WITH_LIMITS, 1.5 * reach), TURNS_WITHOUT_LIMITS)
    allowed = np.where(revolute, turns, LONGEST_SLIDE)
    columns = recording.signals["position"].values.T
    found = np.array([np.max(np.abs(finite(column)), initial=0.0) for column in columns])
    for joint in np.flatnonzero(found > allowed):
        unit = "rad" if revolute[joint] else "m"
        others = columns[revolute & (np.arange(len(columns)) != joint)]
        yield Finding(
            BadUnit,
            f"{recording.robot.joints[joint]} is at {found[joint]:g} {unit}, which it cannot reach (at most "
            f"{allowed[joint]:.3g} {unit} is possible)",
            angle_advice(recording.robot.joints[joint], columns[joint], others)
            if revolute[joint]
            else MILLIMETRES,
        )


def _speed(recording: Recording) -> Iterator[Finding]:
    position = recording.signals["position"]
    # Over some samples: the times of single ones may be those of their arrival.
    apart = max(round(SPAN * position.rate), 1)
    with np.errstate(all="ignore"):  # steps that are none are other findings
        way = np.abs(position.values[apart:] - position.values[:-apart])
        speed = way / (position.time[apart:] - position.time[:-apart])[:, None]
    limits = recording.robot.limits.velocity
    for joint in np.flatnonzero(recording.robot.revolute):
        known, limit = finite(speed[:, joint]), limits[joint]
        # A drive that a robot file lets turn faster does so; a lower limit may be a cell's own.
        fastest = max(FASTEST_TURN, BEYOND_LIMIT * limit) if np.isfinite(limit) else FASTEST_TURN
        # Not the highest: a jump in one sample is another matter.
        usual = np.percentile(known, 95) if len(known) else 0.0
        if usual > fastest:
            yield Finding(
                BadUnit,
                f"{recording.robot.joints[joint]} turns at {usual:g} rad/s in a twentieth of the samples; at "
                f"most {fastest:g} rad/s is possible",
                "Positions in degrees (degrees=True, --degrees), or time in another unit than seconds "
                "(time_scale, --time-scale)? Or state how fast it may turn: [limits] velocity",
            )


def _torque(recording: Recording) -> Iterator[Finding]:
    """Torques measured, or by currents where the robot file states a drive gain."""
    robot = recording.robot
    for name in EFFORT:
        signal = recording.signals.get(name)
        if signal is None:
            continue
        gain = np.ones(robot.dof) if name == "torque" else np.abs(robot.drive_gain)
        stated = (gain != 1.0) | (name == "torque")  # 1 stands for a gain that is not known
        for joint in np.flatnonzero(stated & np.isfinite(robot.limits.torque)):
            known = np.abs(finite(signal.values[:, joint]))
            usual = gain[joint] * np.percentile(known, 95) if len(known) else 0.0
            limit = robot.limits.torque[joint]
            if usual > FAR_BEYOND_TORQUE * limit > 0.0:
                unit = robot.unit(int(joint), "N m")
                yield Finding(
                    BadUnit,
                    f"{robot.joints[joint]}: {usual:.2g} {unit} in a twentieth of the samples, its limit is "
                    f"{limit:g}",
                    _smaller_unit(name, unit),
                )


def _smaller_unit(name: str, unit: str) -> str:
    if name == "torque":
        return f"Is the torque in another unit than {unit}, or the limit ([limits] torque) too low?"
    return (
        'It looks like mA: in a preset.toml beside the log, give [current] column and unit = "mA". Or is '
        "[drive] gain or [limits] torque wrong?"
    )


def _temperature(recording: Recording) -> Iterator[Finding]:
    temperature = recording.signals.get("temperature")
    if temperature is None or not len(temperature):
        return
    for joint, column in zip(recording.robot.joints, temperature.values.T, strict=True):
        known = finite(column)
        if len(known) and np.median(known) > HOTTEST:
            yield Finding(
                BadUnit,
                f"{joint}'s motor is at {np.median(known):g} degC, no motor survives {HOTTEST:g}",
                "It looks like kelvin: subtract 273.15",
            )
