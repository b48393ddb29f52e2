"""Checks of a recording: what is impossible raises an error or a warning, what is unusual a warning.

An error: identifying from this would be wrong; a warning: a person should look at this. A table
from elsewhere in which a joint is at 90 rad is in degrees, and refused. In what exidyn recorded itself, the
joint ran away: such a recording is opened whatever is in it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arm.robot import Limits
from ..errors import BadTime, BadUnit, NotFinite, RecordingError
from .arrival_times import signals_by_stamps, with_regular_clocks
from .effort_checks import effort_warnings
from .incomplete_samples import (
    LARGEST,
    finite,
    is_number,
    without_impossible,
    without_repeats,
    without_silence,
)
from .misread_columns import angle_advice
from .recording import EFFORT, SIGNALS, Recording, Signal
from .restored_signals import restored, without_saturated
from .time_order import Remedy, advice, remedy, steps_back

SLOWEST = 0.5
"""Maximum median period of positions or currents [s]. At 2 Hz an arm's motion is not resolved, but any usual
period in milliseconds (500 Hz: 2.0) exceeds this number."""

POSES = 100
"""Number of slow samples below which they are single poses, as from a pendant, and no log in milliseconds."""

TURNS_WITH_LIMITS = 4 * np.pi
"""Maximum position of a limited joint [rad]: two turns each way, twice the range of common wrists. If the
robot's own limit is higher, the maximum is 1.5 times that limit."""

TURNS_WITHOUT_LIMITS = 20 * np.pi
"""Maximum position of a continuous joint [rad]: beyond ten turns, it is more likely in degrees."""

LONGEST_SLIDE = 100.0
"""Maximum position of a prismatic joint [m]; the same number in millimeters would be a short axis."""

FASTEST_TURN = 20.0
"""Maximum sustained speed of a joint [rad/s], unless its robot file allows more: twice that of the wrists of
the fastest small arms."""
SPAN = 0.1
"""Minimum time over which a speed is computed [s]."""
BEYOND_LIMIT = 1.5
"""Maximum speed over the limit in the robot file; a higher speed indicates another unit."""

FAR_BEYOND_TORQUE = 20.0
"""Maximum torque over the limit in the robot file, in a twentieth of the samples: drives exceed their limits
briefly by a small factor. In mA, a joint that uses a fiftieth of its limit exceeds this."""

HOTTEST = 200.0
"""Maximum temperature of a motor [degC]; in kelvin every motor exceeds it."""

LONGEST = 1e9
"""Maximum duration of a run [s]; nine times as many nanoseconds do not fit into 64 bits."""


class Finding(NamedTuple):
    """Implausible content."""

    kind: type[RecordingError]  # type of the error if the file is from another tool
    fact: str  # the implausible value, and the limit that it exceeds
    advice: str  # advice about such a file; may be empty
    curable: bool = False  # whether an option of the import, such as a unit, may be the cure
    time: float | None = None  # time of the first affected sample [s]; None if there is no such sample

    def error(self, name: str) -> RecordingError:
        """Error for the recording with this name."""
        fact = f"{name}: {self.fact}"
        text = f"{fact}. {self.advice}" if self.advice else fact
        if self.kind is NotFinite:
            return NotFinite(text, self.time)
        error = self.kind(text)
        error.fact = fact * self.curable
        return error


def findings(recording: Recording) -> Iterator[Finding]:
    """All implausible content, signal by signal."""
    for name, signal in recording.signals.items():
        if len(signal):
            yield from _not_finite(recording, name, signal)
            yield from _bad_time(name, signal)
    if len(recording.signals["position"]):
        yield from _turns(recording)
        yield from _speed(recording)
    yield from _torque(recording)
    yield from _temperature(recording)


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
            fault = f"above {LARGEST:g}" if np.isfinite(column).all() else "not finite"
            yield Finding(
                NotFinite,
                f"{name} of {joint} is {fault} in {bad.sum()} of {len(bad)} samples, first at {first:.3f} s",
                advice,
                time=first if np.isfinite(first) else None,
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
            remedy(signal.time, signal.values) in (Remedy.STATE_RATE, Remedy.ALL_EQUAL),
        )
    if name in ("position", *EFFORT) and signal.period > SLOWEST:
        yield Finding(
            BadUnit,
            f"{name} comes every {signal.period:g} s, at most {SLOWEST} s can be followed",
            f"{len(signal)} single poses are no motion: record the samples between them too"
            if len(signal) < POSES
            else "Is time in another unit than seconds?",
            True,
        )


def _turns(recording: Recording) -> Iterator[Finding]:
    limits, revolute = recording.robot.limits, recording.robot.revolute
    reach = np.maximum(np.abs(limits.position_lower), np.abs(limits.position_upper))
    turns = np.where(np.isfinite(reach), np.maximum(TURNS_WITH_LIMITS, 1.5 * reach), TURNS_WITHOUT_LIMITS)
    allowed = np.where(revolute, turns, LONGEST_SLIDE)
    columns = recording.signals["position"].values.T
    peak = np.array([np.max(np.abs(finite(column)), initial=0.0) for column in columns])
    for joint in np.flatnonzero(peak > allowed):
        name, unit = recording.robot.joints[joint], "rad" if revolute[joint] else "m"
        others = columns[revolute & (np.arange(len(columns)) != joint)]
        words = angle_advice(name, columns[joint], others) if revolute[joint] else ""
        yield Finding(
            BadUnit,
            f"{name} is at {peak[joint]:g} {unit}, which it cannot reach (at most {allowed[joint]:.3g} "
            f"{unit} is possible)",
            words or f"Is it in another unit than {unit}?",
            not words,
        )


def _speed(recording: Recording) -> Iterator[Finding]:
    position = recording.signals["position"]
    # Speeds are computed over several samples, since the times of single ones may be those of their arrival.
    apart = max(round(SPAN * position.rate), 1)
    with np.errstate(all="ignore"):  # zero steps are reported by another finding
        distance = np.abs(position.values[apart:] - position.values[:-apart])
        speed = distance / (position.time[apart:] - position.time[:-apart])[:, None]
    limits = recording.robot.limits.velocity
    for joint in np.flatnonzero(recording.robot.revolute):
        # A robot file may allow a higher speed; a lower limit may be specific to a cell.
        stated = BEYOND_LIMIT * limits[joint] if np.isfinite(limits[joint]) else 0.0
        usual, fastest = _usual(speed[:, joint]), max(FASTEST_TURN, stated)
        if usual > fastest:
            yield Finding(
                BadUnit,
                f"{recording.robot.joints[joint]} turns at {usual:g} rad/s in a twentieth of the samples; at "
                f"most {fastest:g} rad/s is possible",
                "Are positions or time in another unit? Or state how fast it may turn: [limits] velocity",
                True,
            )


def _usual(sizes: np.ndarray) -> float:
    """Size that a twentieth of the samples exceed; the highest one may be a jump in a single sample."""
    known = finite(sizes)
    return float(np.percentile(known, 95)) if len(known) else 0.0


def _torque(recording: Recording) -> Iterator[Finding]:
    """Implausible torques, measured or computed from currents if the robot file states a drive gain."""
    robot = recording.robot
    for name in EFFORT:
        signal = recording.signals.get(name)
        if signal is None:
            continue
        gain = np.ones(robot.dof) if name == "torque" else np.abs(robot.drive_gain)
        stated = (gain != 1.0) | (name == "torque")  # 1 stands for a gain that is not known
        for joint in np.flatnonzero(stated & np.isfinite(robot.limits.torque)):
            usual = gain[joint] * _usual(np.abs(signal.values[:, joint]))
            limit = robot.limits.torque[joint]
            if usual > FAR_BEYOND_TORQUE * limit > 0.0:
                unit = robot.unit(int(joint), "N m")
                yield Finding(
                    BadUnit,
                    f"{robot.joints[joint]}: {usual:.2g} {unit} in a twentieth of the samples, its limit is "
                    f"{limit:g}",
                    f"Is the {name} in another unit than {robot.unit(int(joint), SIGNALS[name])}? Or is "
                    "[limits] torque or [drive] gain wrong?",
                    True,
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


GAP = 1.5
"""A step of more median periods than this misses at least one sample, if the clock is regular."""
AS_PLANNED = "none"
"""Stop in the outcome of a run that came to its end."""
BEYOND_LIMITS = 0.1
"""Distance beyond a limit from which there is a warning [rad, m]: encoders read slightly more than the limits
that controllers enforce."""


def check(recording: Recording, in_si: bool = True) -> Recording:
    """The recording without silent samples, and with its warnings.

    Of a log from elsewhere, turns and signs that were lost are restored, and samples that only repeat the one
    before are left out. What exidyn recorded was measured in the units it states; a value that no joint
    should have gives a warning, and samples that are no numbers or whose time goes back are left out.

    Args:
        recording: Recording as it was read.
        in_si: Whether its units are known; otherwise a value that no joint should have gives a warning.

    Raises:
        NotFinite: A joint that was measured has NaN or infinity in between.
        BadTime: Time stamps do not increase.
        BadUnit: Positions, times or temperatures that cannot be in the unit they claim.
    """
    recording = without_repeats(without_silence(recording))
    if recording.recorded:
        recording = without_impossible(recording)
    else:
        recording = without_saturated(restored(with_regular_clocks(recording)))
    warnings = []
    for finding in findings(recording):
        if finding.kind is not BadUnit or (in_si and not recording.recorded):
            raise finding.error(recording.name)
        warnings.append(finding.fact)
    return _with_warnings(recording, warnings)


def check_recorded(recording: Recording) -> Recording:
    """A recording that exidyn wrote, without silent samples, and with a warning for all that cannot be."""
    recording = without_silence(replace(recording, recorded=True))
    return _with_warnings(recording, [finding.fact for finding in findings(recording)])


class DerivedWarning(str):
    """A warning that follows from the recording itself, so that the checks give it anew."""

    __slots__ = ()


def _with_warnings(recording: Recording, impossible: Sequence[str]) -> Recording:
    facts = [*_stopped(recording), *_gaps(recording)]
    if len(recording.signals["position"]):
        facts += _beyond_limits(recording)
    derived = [DerivedWarning(fact) for fact in (*facts, *effort_warnings(recording), *impossible)]
    # Gaps are counted anew, since samples may have been lost since.
    valid = (
        warning
        for warning in recording.warnings
        if warning in derived or not isinstance(warning, DerivedWarning)
    )
    return replace(recording, warnings=tuple(valid)).with_warnings(*derived)


def _stopped(recording: Recording) -> list[str]:
    """That a run was stopped before its motion came to its end, and why."""
    outcome = recording.outcome
    if outcome.get("stop", AS_PLANNED) == AS_PLANNED:
        return []
    why = outcome.get("text") or " ".join(filter(None, (outcome["stop"], outcome.get("joint"))))
    return [f"was stopped early, after {recording.duration:.3g} s: {why}"]


def _gaps(recording: Recording) -> list[str]:
    """Warnings about time stamps with holes, once for all signals that share the stamps or the holes."""
    names_by_fact: dict[str, list[str]] = {}
    for names in signals_by_stamps(recording):
        signal = recording.signals[names[0]]
        steps = np.diff(signal.time)
        long = steps > GAP * signal.period
        if long.any():
            fact = (
                f"{long.sum()} gap{'s' * bool(long.sum() > 1)} of more than {GAP} median periods of "
                f"{signal.period * 1e3:.3f} ms, the longest {steps.max() * 1e3:.3f} ms, the first at "
                f"{signal.time[:-1][long][0]:.3f} s"
            )
            names_by_fact.setdefault(fact, []).extend(names)
    return [f"{', '.join(names)}: {fact}" for fact, names in names_by_fact.items()]


def _beyond_limits(recording: Recording) -> list[str]:
    beyond = beyond_limits(recording.robot.limits, recording.signals["position"].values)
    return [
        f"position: {recording.robot.joints[joint]} goes {beyond[joint]:.3g} rad or m beyond its limits; is "
        "its zero where the robot's description has it?"
        for joint in np.flatnonzero(beyond > BEYOND_LIMITS)
    ]


def beyond_limits(limits: Limits, position: np.ndarray) -> np.ndarray:
    """Largest distance of positions (t, n) beyond the limits of each joint, negative within them, (n,)."""
    columns = [finite(column) for column in position.T]
    lowest = np.array([np.min(column, initial=np.inf) for column in columns])
    highest = np.array([np.max(column, initial=-np.inf) for column in columns])
    return np.maximum(limits.position_lower - lowest, highest - limits.position_upper)
