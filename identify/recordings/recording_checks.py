"""Checks of a recording: what is impossible raises an error or a warning, what is unusual a warning.

An error: identifying from this would be wrong; a warning: a person should look at this. A table
from elsewhere in which a joint is at 90 rad is in degrees, and refused. In what exidyn recorded itself, the
joint ran away: such a recording is opened whatever is in it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..errors import BadUnit, NotRecorded
from ..schema import LARGEST
from .arrival_times import signals_by_stamps, with_regular_clocks
from .recording import EFFORT, Recording, Signal
from .recording_findings import findings, finite, is_number
from .restored_signals import restored
from .saturated import without_saturated
from .servo_error import is_servo_error

GAP = 1.5
"""A step of more median periods than this misses at least one sample, if the clock is regular."""

CLIPPED_SAMPLES = 20
"""Samples at exactly the extreme value from which on it is worth asking, 40 ms at 500 Hz."""

CLIPPED_CROWD = 10.0
"""How many times more samples lie at the extreme than at the values next to it. At the crest of a smooth
quantised signal it is at most five; a limiter collects everything that would have been beyond."""

TAKEN_SLOWLY = ("temperature",)
"""Signals that change over minutes: controllers ask one motor after another, and what is asked in the next
tenth of a second may be taken for now."""

AS_PLANNED = "none"
"""Stop in the outcome of a run that came to its end."""
UNREAD = 0.5
"""Share of samples in motion at one value from which on the value is the median, whatever the joint does."""
UNMEASURED = "efforts at one value in most samples in which their joint moves, as if they were not measured"
NO_MOTOR = "state the joint in robot.toml, [drive] passive"
WINDOW = 0.1
"""Time over which a joint's motion is looked at [s]; over less, the steps of an encoder look like rest."""
FEWEST = 50
"""Samples in motion, at least: of a few, most may well be alike."""
SLOW = 0.03
"""Share of a joint's usual speed below which it may as well rest."""


def check(recording: Recording) -> Recording:
    """The recording without silent samples, and with its warnings.

    Of a log from elsewhere, turns and signs that were lost are restored, and samples that only repeat the one
    before are left out. What exidyn recorded was measured in the units it states; a value that no joint
    should have gives a warning, and samples that are no numbers or whose time goes back are left out.

    Raises:
        NotFinite: A joint that was measured has NaN or infinity in between.
        BadTime: Time stamps do not increase.
        BadUnit: Positions, times or temperatures that cannot be in the unit they claim.
    """
    recording = _without_silence(recording)
    if recording.recorded:
        recording = _without_impossible(recording)
    else:
        recording = without_saturated(restored(with_regular_clocks(recording)))
    warnings = []
    for finding in findings(recording):
        if not (recording.recorded and finding.kind is BadUnit):
            raise finding.error(recording.name)
        warnings.append(finding.fact)
    return _with_warnings(recording, warnings)


def check_recorded(recording: Recording) -> Recording:
    """A recording that exidyn wrote, without silent samples, and with a warning for all that cannot be."""
    recording = _without_silence(replace(recording, recorded=True))
    return _with_warnings(recording, [finding.fact for finding in findings(recording)])


class DerivedWarning(str):
    """A warning that follows from the recording itself, so that the checks give it anew."""

    __slots__ = ()


def imported_warnings(recording: Recording) -> tuple[str, ...]:
    """The warnings that a file has to hold: those of its import."""
    return tuple(warning for warning in recording.warnings if not isinstance(warning, DerivedWarning))


def _with_warnings(recording: Recording, impossible: Sequence[str]) -> Recording:
    derived = [DerivedWarning(warning) for warning in (*_derived(recording), *impossible)]
    # Gaps are counted anew, since samples may have been lost since.
    valid = (
        warning
        for warning in recording.warnings
        if warning in derived or not isinstance(warning, DerivedWarning)
    )
    return replace(recording, warnings=tuple(valid)).with_warnings(*derived)


def _derived(recording: Recording) -> list[str]:
    """Warnings that follow from the signals and the outcome."""
    warnings = [*_stopped(recording), *_gaps(recording)]
    if len(recording.signals["position"]):
        warnings += _beyond_limits(recording)
    for name in EFFORT:
        warnings += _unmeasured(recording, name) or _dead(recording, name)
        warnings += [*_limited(recording, name), *_unread(recording, name)]
    return warnings


def _stopped(recording: Recording) -> list[str]:
    """That a run was stopped before its motion came to its end, and why."""
    outcome = recording.outcome
    if outcome.get("stop", AS_PLANNED) == AS_PLANNED:
        return []
    why = outcome.get("text") or " ".join(filter(None, (outcome["stop"], outcome.get("joint"))))
    return [f"was stopped early, after {recording.duration:.3g} s: {why}"]


def check_alive(recording: Recording) -> Recording:
    """The recording, if every motor's current changes.

    Raises:
        NotRecorded: One is constant; as a torque it would mean that the joint weighs nothing.
    """
    dead = [
        warning for name in EFFORT for warning in (_unmeasured(recording, name) or _dead(recording, name))
    ]
    if dead:
        raise NotRecorded(
            f"{recording.name}: {'; '.join(dead)}. Identify from runs in which all are measured"
        )
    return recording


def still_at(values: np.ndarray) -> np.ndarray:
    """The value of each column (t, n) in all samples, shape (n,); NaN where it changes, or has none."""
    known = is_number(values)
    lowest, highest = (
        function(values, axis=0, where=known, initial=start)
        for function, start in ((np.min, np.inf), (np.max, -np.inf))
    )
    return np.where(lowest == highest, lowest, np.nan)


def unmeasured_words(values: np.ndarray) -> str:
    """That efforts (t, n) were not measured, as none of them ever changes; empty where any does."""
    still = still_at(values)
    if not len(still) or np.isnan(still).any():
        return ""
    how = f"{still[0] + 0.0:g}" if np.all(still == still[0]) else "constant"
    return f"no effort was measured: all efforts are {how} throughout"


def _unmeasured(recording: Recording, name: str) -> list[str]:
    """That no effort of any motor was measured; of a joint without one, it need not be."""
    signal = recording.signals.get(name)
    motors = ~np.isin(recording.robot.joints, recording.robot.passive)
    if signal is None or len(signal) < 2 or not motors.any():
        return []
    words = unmeasured_words(signal.values[:, motors])
    return [f"{name}: {words}"] if words else []


def _dead(recording: Recording, name: str) -> list[str]:
    """Warnings about motors whose effort does not change."""
    signal = recording.signals.get(name)
    if signal is None or len(signal) < 2:
        return []
    warnings = []
    for joint, value in zip(recording.robot.joints, still_at(signal.values), strict=True):
        if np.isfinite(value) and (value != 0.0 or joint not in recording.robot.passive):
            cure = "" if value else f". If it has no motor: {NO_MOTOR}"
            warnings.append(
                f"{name}: {joint} is constant at {value + 0.0:g}; it was not measured, or the motor was off"
                f"{cure}"
            )
    return warnings


def _without_silence(recording: Recording) -> Recording:
    """Drop samples in which a signal is NaN on all joints: the controller sent nothing then."""
    return recording.keeping(
        {name: ~np.isnan(signal.values).all(axis=1) for name, signal in recording.signals.items()}
    )


def _without_impossible(recording: Recording) -> Recording:
    """Drop samples in which a joint is not a number, if it is one elsewhere, or whose time goes back."""
    valid, warnings = {}, []
    for name, signal in recording.signals.items():
        known = is_number(signal.values)
        known[:, ~known.any(axis=0)] = True
        last_time = np.maximum.accumulate(np.concatenate([[-np.inf], signal.time]))[:-1]
        used = valid[name] = known.all(axis=1) & (signal.time > last_time)
        if not used.all():
            warnings.append(
                f"{name}: {np.sum(~used)} of {len(used)} samples have a joint that is not a number or a time "
                "that goes back; they are left out"
            )
    return recording.keeping(valid).with_warnings(*warnings)


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
    limits = recording.robot.limits
    columns = [finite(column) for column in recording.signals["position"].values.T]
    lowest = np.array([np.min(column, initial=np.inf) for column in columns])
    highest = np.array([np.max(column, initial=-np.inf) for column in columns])
    beyond = np.maximum(limits.position_lower - lowest, highest - limits.position_upper)
    # A tenth of a radian: encoders see a little more than the limits that controllers enforce.
    return [
        f"position: {recording.robot.joints[joint]} goes {beyond[joint]:.3g} rad or m beyond its limits; is "
        "its zero where the robot's description has it?"
        for joint in np.flatnonzero(beyond > 0.1)
    ]


def _limited(recording: Recording, name: str) -> list[str]:
    """Warnings about efforts that stop at a limit; those of servo errors compare with the servo's limit."""
    signal = recording.signals.get(name)
    if signal is None or len(signal) < 2 or is_servo_error(recording.settings):
        return []
    warnings = []
    for joint, values in zip(recording.robot.joints, signal.values.T, strict=True):
        column = finite(values)
        for extreme in (column.min(), column.max()) if len(column) and np.ptp(column) > 0 else ():
            if count := _clipped(column, extreme):
                warnings.append(
                    f"{name}: {joint} is at exactly {extreme:g} in {count} samples, more than "
                    f"{CLIPPED_CROWD:g} times as often as near it: it is clipped there"
                )
    return warnings


def _unread(recording: Recording, name: str) -> list[str]:
    """Warnings about efforts that stay at one value while their joint moves."""
    signal, position = recording.signals.get(name), recording.signals["position"]
    if signal is None or min(len(signal), len(position)) < 2:
        return []
    moved = np.column_stack([np.interp(signal.time, position.time, column) for column in position.values.T])
    shares = unread(signal.time, moved, signal.values)
    held = [
        f"{joint} in {100 * share:.0f} %"
        for joint, share in zip(recording.robot.joints, shares, strict=True)
        if 0.0 < share < 1.0
    ]
    return [f"{name}: {UNMEASURED}: {', '.join(held)}"] if held else []


def _clipped(column: np.ndarray, extreme: float) -> int:
    """Samples at an extreme value if they crowd there, else zero."""
    at = int((column == extreme).sum())
    if at < CLIPPED_SAMPLES:
        return 0
    order = np.sort(np.abs(column[column != extreme] - extreme))
    neighbours = np.unique(order[: 10 * at], return_counts=True)[1][:10]
    return at if at > CLIPPED_CROWD * neighbours.mean() else 0


def unread(time: np.ndarray, position: np.ndarray, effort: np.ndarray) -> np.ndarray:
    """Share of the samples in motion at which each effort has its most frequent value, shape (n,).

    Args:
        time: Time of the samples, shape (t,) [s].
        position: Shape (t, n).
        effort: Effort in any unit, shape (t, n).

    Returns:
        Zero where a joint does not move, or up to `UNREAD`.
    """
    shares = [_share(time, column, measured) for column, measured in zip(position.T, effort.T, strict=True)]
    return np.where(np.array(shares) > UNREAD, shares, 0.0)


def _share(time: np.ndarray, position: np.ndarray, effort: np.ndarray) -> float:
    known = np.abs(position) < LARGEST
    if known.sum() < FEWEST:
        return 0.0
    later, before = (np.interp(time + x * WINDOW / 2, time[known], position[known]) for x in (1, -1))
    moved = np.abs(later - before)
    there = (moved > SLOW * np.percentile(moved, 90)) & np.isfinite(effort)
    if there.sum() < FEWEST:
        return 0.0
    return float(np.unique(effort[there], return_counts=True)[1].max() / there.sum())


def without_stale(recording: Recording) -> Recording:
    """The recording without samples that lack a joint, and with a warning that gives their number and joints.

    What the other joints sent in the same cycle is left out with them: dynamics couples the joints, so that a
    row with a hole is of no use, and one that was filled in would pretend to have been measured. A joint
    that never sent a value is left for `check` to judge.
    """
    filled, fresh, warnings = {}, {}, []
    for name, signal in recording.signals.items():
        silent = np.isnan(signal.values)
        silent[:, silent.all(axis=0)] = False
        stale = silent.any(axis=1)
        if name in TAKEN_SLOWLY:
            filled[name] = _filled(signal) if stale.any() else signal
            continue
        fresh[name] = ~stale
        if np.isfinite(signal.values[stale]).any():
            warnings.append(_stale_warning(recording, name, silent, stale))
    complete = replace(recording, signals={**recording.signals, **filled})
    return complete.keeping(fresh).with_warnings(*warnings)


def _filled(signal: Signal) -> Signal:
    """A straight line between the samples of a joint before and after."""
    values = np.array(signal.values)
    for column in values.T:
        known = np.isfinite(column)
        if known.any():
            column[:] = np.interp(signal.time, signal.time[known], column[known])
    return Signal(signal.time, values)


def _stale_warning(recording: Recording, name: str, silent: np.ndarray, stale: np.ndarray) -> str:
    joints = [
        f"{joint} in {count}"
        for joint, count in zip(recording.robot.joints, silent.sum(axis=0), strict=True)
        if count
    ]
    return (
        f"{name}: a joint was silent in {stale.sum()} of {len(stale)} samples ({', '.join(joints)}); they "
        "are left out"
    )
