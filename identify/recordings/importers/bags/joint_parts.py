"""Joints that come in different messages, as of two motor boards: their samples at common times.

The times are those of the joints that come most seldom, so that no sample is invented. Positions of the
others are interpolated by a cubic spline and the rest by straight lines, as signals of other rates are.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from ....errors import RecordingError
from ....text_table import digits
from .bag_reader import Group

CLOCKS_AGREE = 0.05
"""Difference of the latencies of two publishers on one robot [s], at most: networks and schedulers delay a
message by some milliseconds. A larger difference is that of their clocks."""
SECOND = 1_000_000_000
"""Longest time between two messages of a joint that moves [ns]."""
BRIDGED = 2.5
"""Periods between two samples of a joint across which it is interpolated: one lost sample, with jitter."""
BRIDGED_TIME = 0.05
"""Time that is bridged in any case [s], as messages may be received in bursts: a tenth of the period of 2 Hz,
above which arms hardly move."""


@dataclass(frozen=True)
class Part:
    """Joints that come in the same messages.

    Attributes:
        names: Names of the joints, n of them.
        topics: Where they come from.
        received: When the bag received each message, shape (t,) [ns].
        stamp: Time stamps by the messages, shape (t,) [ns].
        rows: Field -> values, shape (t, n); NaN where a message does not have them.
    """

    names: tuple[str, ...]
    topics: tuple[str, ...]
    received: np.ndarray
    stamp: np.ndarray
    rows: dict[str, np.ndarray]

    def __str__(self) -> str:
        return f"{', '.join(self.names)} on {' and '.join(self.topics)}"

    def only(self, joints: Sequence[int]) -> "Part":
        """Some of the joints, in the messages that have any value of them."""
        rows = {name: values[:, joints] for name, values in self.rows.items()}
        there = np.any([np.isfinite(values).any(axis=1) for values in rows.values()], axis=0)
        return Part(
            tuple(self.names[joint] for joint in joints), self.topics, self.received[there],
            self.stamp[there], {name: values[there] for name, values in rows.items()},
        )  # fmt: skip


def parts_of(groups: Sequence[Group], names: Sequence[str]) -> list[Part]:
    """The joints of a robot, by the messages in which they come; one part where messages have all of them."""
    complete = [group for group in groups if set(names) <= set(group.names)]
    sources = complete or groups
    sharing: dict[tuple[int, ...], list[str]] = {}
    for name in names:
        places = tuple(place for place, group in enumerate(sources) if name in group.names)
        sharing.setdefault(places, []).append(name)
    parts = [_merged([sources[k] for k in places], joints) for places, joints in sharing.items()]
    return [piece for part in parts for piece in _by_values(part)]


def _merged(groups: Sequence[Group], names: Sequence[str]) -> Part:
    """Some joints of several groups, in the order in which the bag received the messages."""
    received = np.concatenate([group.received for group in groups])
    order = np.argsort(received, kind="stable")
    rows = {}
    for field in dict.fromkeys(field for group in groups for field in group.rows):
        values = [_columns(group, field, names) for group in groups]
        rows[field] = np.concatenate(values)[order]
    stamp = np.concatenate([group.stamp for group in groups])[order]
    topics = tuple(dict.fromkeys(group.topic for group in groups))
    return Part(tuple(names), topics, received[order], stamp, rows)


def _columns(group: Group, field: str, names: Sequence[str]) -> np.ndarray:
    places = [group.names.index(name) for name in names]
    silent = np.full((len(group.received), len(names)), np.nan)
    return group.rows[field][:, places] if field in group.rows else silent


def _by_values(part: Part) -> list[Part]:
    """The part, or its joints by the messages with values, where boards leave the others' joints NaN."""
    known = {field: np.isfinite(values) for field, values in part.rows.items()}
    divided = False
    for measured in known.values():
        ever = measured.any(axis=0)
        divided |= bool(ever.any() and not measured[:, ever].all(axis=1).any())
    if not divided:
        return [part]
    pieces: dict[bytes, list[int]] = {}
    for joint in range(len(part.names)):
        pattern = np.array([measured[:, joint] for measured in known.values()]).tobytes()
        pieces.setdefault(pattern, []).append(joint)
    return [part.only(joints) for joints in pieces.values()]


def clock_of(parts: Sequence[Part]) -> tuple[list[np.ndarray], list[str]]:
    """Times of each part, shape (t,) [ns], and a note where they are not those of the messages.

    The stamps of the messages count, as the bag's times are late by the network. Where stamps are not set,
    stand still, or are of clocks that disagree, the bag's times count.
    """
    received, stamps = [part.received for part in parts], [part.stamp for part in parts]
    every = np.concatenate(stamps)
    if not every.any():
        return received, []  # which is usual, and no times are lost
    late = [float(np.median(part.received - part.stamp)) * 1e-9 for part in parts]
    reason = ""
    if any(_unset(stamp) for stamp in stamps):
        reason = f"{np.sum(every == 0)} of {len(every)} messages have no time stamp"
    elif any(len(stamp) > 1 and np.ptp(stamp) == 0 for stamp in stamps):
        reason = "the time stamps of the messages stand still"
    elif max(late) - min(late) > CLOCKS_AGREE:
        reason = f"the clocks of the publishers differ by {digits(max(late) - min(late))} s"
    return (
        (received, [f"{reason}: times are those at which the bag received them"]) if reason else (stamps, [])
    )


def _unset(stamp: np.ndarray) -> bool:
    """Whether stamps (t,) [ns] of zero were not set: a clock that begins at zero shows that once."""
    zeros = int(np.sum(stamp == 0))
    return zeros > 1 or 0 < zeros < len(stamp) and int(stamp[stamp > 0].min()) > SECOND


def joined(source: str, parts: Sequence[Part], times: Sequence[np.ndarray]) -> tuple[Part, np.ndarray, str]:
    """All joints at common times.

    Args:
        source: What errors call the bag.
        parts: Joints that come in different messages.
        times: Times of each part, shape (t,) [ns].

    Returns:
        All joints as one part; its times, shape (t,) [ns]; and a warning that says what was done.

    Raises:
        RecordingError: The joints have no time in common.
    """
    ordered = [np.unique(time) for time in times]
    periods = [_period(time) for time in ordered]
    slowest = int(np.argmax(periods))
    time, places = np.unique(times[slowest], return_index=True)
    common = (time >= max(known[0] for known in ordered)) & (time <= min(known[-1] for known in ordered))
    if common.sum() < 2:
        raise RecordingError(
            f"{source}: joints come in different messages that have no time in common: "
            f"{'; '.join(map(str, parts))}. Record all at the same time, by one clock"
        )
    time, places = time[common], places[common]
    fields = dict.fromkeys(field for part in parts for field in part.rows)
    whole = Part(
        tuple(name for part in parts for name in part.names),
        tuple(dict.fromkeys(topic for part in parts for topic in part.topics)),
        parts[slowest].received[places],
        parts[slowest].stamp[places],
        {
            field: np.hstack([_at(time, *each, field) for each in zip(times, parts, strict=True)])
            for field in fields
        },
    )
    apart = max(float(np.median(_distance(time, known))) for known in ordered)
    rates = (f"{part} ({1e9 / period:.4g} Hz)" for part, period in zip(parts, periods, strict=True))
    warning = (
        f"no message has all joints: {' and '.join(rates)}, {1e-6 * apart:.3g} ms apart. All are "
        f"interpolated to the times of {parts[slowest].names[0]}"
    )
    return whole, time, warning


def _period(time: np.ndarray) -> float:
    """Mean period of sorted times (t,) [ns]; endless for fewer than two."""
    return float(np.ptp(time)) / (len(time) - 1) if len(time) > 1 else float("inf")


def _bridged(time: np.ndarray, known: np.ndarray, longest: float) -> np.ndarray:
    """Which times (t,) lie at a sample or between two that are no further apart than `longest` [ns]."""
    after = np.searchsorted(known, time)
    before = np.searchsorted(known, time, side="right") - 1
    inside = (before >= 0) & (after < len(known))
    span = known[np.minimum(after, len(known) - 1)] - known[np.maximum(before, 0)]
    return inside & (span <= longest)


def _distance(time: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Distance of each time to the nearest that is known, shape (t,) [ns]."""
    after = np.clip(np.searchsorted(known, time), 1, len(known) - 1)
    return np.minimum(np.abs(known[after] - time), np.abs(time - known[after - 1]))


def _at(time: np.ndarray, known: np.ndarray, part: Part, field: str) -> np.ndarray:
    """A field of a part at other times, shape (t, n); NaN where samples are missing."""
    values = np.full((len(time), len(part.names)), np.nan)
    for joint, column in enumerate(part.rows[field].T if field in part.rows else ()):
        measured = np.isfinite(column)
        there, first = np.unique(known[measured], return_index=True)
        if len(there) < 2:
            continue
        column = column[measured][first]
        # From the first time on: a double holds no nanoseconds since 1970.
        since, wanted = (there - there[0]) * 1e-9, (time - there[0]) * 1e-9
        smooth = field == "position" and len(there) > 3
        row = CubicSpline(since, column)(wanted) if smooth else np.interp(wanted, since, column)
        longest = max(BRIDGED * _period(there), 1e9 * BRIDGED_TIME)
        values[:, joint] = np.where(_bridged(time, there, longest), row, np.nan)
    return values
