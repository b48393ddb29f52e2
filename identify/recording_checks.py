"""What cannot be, and what should be doubted, in a recording.

An error says that identifying from this would be wrong; a warning says what a person should look at.
"""

import re
from dataclasses import replace

import numpy as np

from .errors import BadTime, BadUnit, NotFinite, NotRecorded
from .recording import EFFORT, Recording, Signal

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
"""Speed that no joint of an arm keeps up [rad/s]: twice that of the fastest small arms' wrists."""

HOTTEST = 200.0
"""Temperature that no motor survives [degC]; in kelvin every motor is above."""

GAP = 1.5
"""A step of more median periods than this misses at least one sample, if the clock is regular."""

GAPS_SAID = re.compile(r": \d+ gaps? of more than ")
"""What a doubt about gaps looks like."""

CLIPPED_SAMPLES = 20
"""Samples at exactly the extreme value from which on it is worth asking, 40 ms at 500 Hz."""

CLIPPED_CROWD = 10.0
"""How many times more samples lie at the extreme than at the values next to it. At the crest of a smooth
quantised signal it is at most five; a limiter collects everything that would have been beyond."""


def check(recording: Recording) -> Recording:
    """The recording without silent samples, and with its doubts.

    Raises:
        NotFinite: A joint that was measured has NaN or infinity in between.
        BadTime: Time stamps do not increase.
        BadUnit: Positions, times or temperatures that cannot be in the unit they claim.
    """
    recording = _without_silence(recording)
    doubts = _gaps(recording)
    for name, signal in recording.signals.items():
        if len(signal):
            _check_finite(recording, name, signal)
            _check_time(recording, name, signal)
    if len(recording.signals["position"]):
        _check_turns(recording)
        doubts += _beyond_limits(recording)
    _check_temperature(recording)
    doubts += [doubt for name in EFFORT for doubt in _stuck(recording, name)]
    # A file brings the doubts of its import. Gaps are counted anew, as some of it may have been lost since.
    still = tuple(said for said in recording.warnings if said in doubts or not GAPS_SAID.search(said))
    return replace(recording, warnings=still).doubted(*doubts)


def check_alive(recording: Recording) -> Recording:
    """The recording, if every motor's current changes.

    Raises:
        NotRecorded: One is constant; as a torque it would say that the joint weighs nothing.
    """
    for name in EFFORT:
        dead = [doubt for doubt in _stuck(recording, name) if " is constant at " in doubt]
        if dead:
            raise NotRecorded(
                f"{recording.name}: {'; '.join(dead)}. Identify from runs in which all are measured"
            )
    return recording


def _without_silence(recording: Recording) -> Recording:
    """Drop samples in which a signal is NaN on all joints: the controller said nothing then."""
    signals = dict(recording.signals)
    host_time = recording.host_time
    for name, signal in recording.signals.items():
        speaks = ~np.isnan(signal.values).all(axis=1)
        if speaks.all():
            continue
        signals[name] = signal[speaks]
        if name == "position" and host_time is not None:
            host_time = host_time[speaks]
    return replace(recording, signals=signals, host_time=host_time)


def _check_finite(recording: Recording, name: str, signal: Signal) -> None:
    if not np.isfinite(signal.time).all():
        raise NotFinite(f"{recording.name}: time of {name} is not finite in {_bad(signal.time)} samples")
    optional = name not in ("position", *EFFORT)
    for joint, column in zip(recording.robot.joints, signal.values.T, strict=True):
        bad = ~np.isfinite(column)
        if bad.any() and not (optional and np.isnan(column).all()):
            raise NotFinite(
                f"{recording.name}: {name} of {joint} is not finite in {bad.sum()} of {len(bad)} samples, "
                f"first at {signal.time[bad.argmax()]:.3f} s. Leave such samples out; time stamps need not "
                "be regular",
                time=float(signal.time[bad.argmax()]),
            )


def _bad(values: np.ndarray) -> int:
    return int((~np.isfinite(values)).sum())


def _check_time(recording: Recording, name: str, signal: Signal) -> None:
    steps = np.diff(signal.time)
    back = np.flatnonzero(steps <= 0)
    if len(back):
        first = back[0]
        raise BadTime(
            f"{recording.name}: time of {name} does not increase at {len(back)} of {len(steps)} steps, first "
            f"from {signal.time[first]:.6f} s to {signal.time[first + 1]:.6f} s. Sort the samples, or leave "
            "out what is wrong (at the beginning of a table: skip_rows, --skip-rows)"
        )
    if name in ("position", *EFFORT) and signal.period > SLOWEST:
        raise BadUnit(
            f"{recording.name}: {name} comes every {signal.period:g} s, at most {SLOWEST} s can be followed. "
            f"In milliseconds that would be {1e3 / signal.period:g} Hz: import with time_scale=0.001 "
            "(--time-scale 0.001)"
        )


def _gaps(recording: Recording) -> list[str]:
    """Doubts about time stamps with holes, once for all signals that share the stamps or the holes."""
    sharing: dict[bytes, list[str]] = {}
    for name, signal in recording.signals.items():
        sharing.setdefault(signal.time.tobytes(), []).append(name)
    found: dict[str, list[str]] = {}
    for names in sharing.values():
        signal = recording.signals[names[0]]
        steps = np.diff(signal.time)
        long = steps > GAP * signal.period
        if long.any():
            fact = (
                f"{long.sum()} gap{'s' * bool(long.sum() > 1)} of more than {GAP} median periods of "
                f"{signal.period * 1e3:.3f} ms, the longest {steps.max() * 1e3:.3f} ms, the first at "
                f"{signal.time[:-1][long][0]:.3f} s"
            )
            found.setdefault(fact, []).extend(names)
    return [f"{', '.join(names)}: {fact}" for fact, names in found.items()]


def _check_turns(recording: Recording) -> None:
    position, limits = recording.signals["position"], recording.robot.limits
    reach = np.maximum(np.abs(limits.position_lower), np.abs(limits.position_upper))
    limited = np.isfinite(reach)
    turns = np.where(limited, np.maximum(TURNS_WITH_LIMITS, 1.5 * reach), TURNS_WITHOUT_LIMITS)
    revolute = recording.robot.revolute
    allowed = np.where(revolute, turns, LONGEST_SLIDE)
    found = np.abs(position.values).max(axis=0)
    for joint in np.flatnonzero(found > allowed):
        name = recording.robot.joints[joint]
        degrees, slides = (
            ("rad", "degrees", "degrees=True (--degrees)"),
            ("m", "millimetres", "positions in metres"),
        )
        unit, smaller, option = degrees if revolute[joint] else slides
        raise BadUnit(
            f"{recording.name}: {name} is at {found[joint]:g} {unit}, which it cannot "
            f"reach (at most {allowed[joint]:.3g} {unit} is believed). It looks like {smaller}: import with "
            f"{option}"
        )
    if len(position) > 1:
        _check_speed(recording, position, revolute)


def _check_speed(recording: Recording, position: Signal, revolute: np.ndarray) -> None:
    speed = np.abs(np.diff(position.values, axis=0)) / np.diff(position.time)[:, None]
    usual = np.percentile(speed, 95, axis=0)  # not the highest: a jump in one sample is another matter
    for joint in np.flatnonzero(revolute & (usual > FASTEST_TURN)):
        raise BadUnit(
            f"{recording.name}: {recording.robot.joints[joint]} turns at {usual[joint]:g} rad/s in a "
            f"twentieth of the samples; at most {FASTEST_TURN:g} rad/s is believed. Positions in degrees "
            "(degrees=True, --degrees), or time in another unit than seconds (time_scale, --time-scale)?"
        )


def _beyond_limits(recording: Recording) -> list[str]:
    values, limits = recording.signals["position"].values, recording.robot.limits
    beyond = np.maximum(
        limits.position_lower - values.min(axis=0), values.max(axis=0) - limits.position_upper
    )
    # A tenth of a radian: encoders see a little more than the limits that controllers enforce.
    return [
        f"position: {recording.robot.joints[joint]} goes {beyond[joint]:.3g} rad or m beyond its limits; is "
        "its zero where the robot's description has it?"
        for joint in np.flatnonzero(beyond > 0.1)
    ]


def _check_temperature(recording: Recording) -> None:
    temperature = recording.signals.get("temperature")
    if temperature is None or not len(temperature):
        return
    for joint, column in zip(recording.robot.joints, temperature.values.T, strict=True):
        if np.isfinite(column).any() and np.nanmedian(column) > HOTTEST:
            raise BadUnit(
                f"{recording.name}: {joint}'s motor is at {np.nanmedian(column):g} degC, no motor survives "
                f"{HOTTEST:g}. It looks like kelvin: subtract 273.15"
            )


def _stuck(recording: Recording, name: str) -> list[str]:
    """Doubts about currents that do not change or stop at a limit."""
    signal = recording.signals.get(name)
    if signal is None or len(signal) < 2:
        return []
    doubts = []
    for joint, column in zip(recording.robot.joints, signal.values.T, strict=True):
        if np.ptp(column) == 0:
            doubts.append(
                f"{name}: {joint} is constant at {column[0] + 0.0:g}; it was not measured, or the motor was "
                "off"
            )
            continue
        for extreme in (column.min(), column.max()):
            count = _clipped(column, extreme)
            if count:
                doubts.append(
                    f"{name}: {joint} is at exactly {extreme:g} in {count} samples, more than "
                    f"{CLIPPED_CROWD:g} times as often as near it: it is clipped there"
                )
    return doubts


def _clipped(column: np.ndarray, extreme: float) -> int:
    """Samples at an extreme value if they crowd there, else zero."""
    at = int((column == extreme).sum())
    if at < CLIPPED_SAMPLES:
        return 0
    order = np.sort(np.abs(column[column != extreme] - extreme))
    neighbours = np.unique(order[: 10 * at], return_counts=True)[1][:10]
    return at if at > CLIPPED_CROWD * neighbours.mean() else 0
