"""Topics of a bag that hold the joints of a robot, the names there, and the joints at common times.

If joints are in different messages, such as those of two motor boards, the times are those of the joints with
the lowest rate, so that no samples are invented. Positions of the others are interpolated with a cubic
spline, and other fields linearly, like signals of other rates.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from ...arm.robot import Robot
from ...errors import RecordingError, listed
from ...text_table import digits
from ..tables.columns import find_joints
from .bag_files import JOINT_READERS, JSON
from .bag_reader import Group

PLAIN = (next(iter(JOINT_READERS)), JSON)
"""Types of messages with only joint states, which are preferred."""
USUAL = "/joint_states"
"""Topic that is chosen if several topics have all joints."""


def choose_topics(
    source: Path,
    groups: Sequence[Group],
    robot: Robot,
    topic: str | None = None,
    joints: str | Sequence[str] | None = None,
) -> tuple[list[Group], list[str]]:
    """Joint states of a robot, and the names of its joints in them.

    By default, the topic is the one with all joints, or all topics with any of them.
    """
    if topic is not None:
        return _of_topics(source, groups, robot, topic.split(","), joints)
    names = find_joints(robot, names_in(groups), joints, f"{source}")
    complete = {
        name: topic for name, topic in _by_topic(groups).items() if set(names) <= set(names_in(topic))
    }
    if complete:
        return complete[_best(source, complete)], names
    plain = [group for group in groups if group.kind in PLAIN]
    sources = plain if set(names) <= set(names_in(plain)) else list(groups)
    for name in names:
        having = [topic for topic, sharing in _by_topic(sources).items() if name in names_in(sharing)]
        if len(having) > 1:
            raise RecordingError(
                f"{source}: no topic has all joints, and '{name}' is on {' and '.join(having)}; choose the "
                "topics of all joints by --topic TOPIC,TOPIC"
            )
    return [group for group in sources if set(names) & set(group.names)], names


def _best(source: Path, complete: Mapping[str, Sequence[Group]]) -> str:
    """Best of several topics with all joints: preferably one with efforts and with plain joint states."""
    ranks = {topic: _rank(groups) for topic, groups in complete.items()}
    best = [topic for topic, rank in ranks.items() if rank == min(ranks.values())]
    if len(best) > 1 and USUAL not in best:
        raise RecordingError(
            f"{source}: several topics have the robot's joints. Topics with joint states: {', '.join(best)}; "
            "choose one by --topic TOPIC"
        )
    return best[0] if len(best) == 1 else USUAL


def _rank(groups: Sequence[Group]) -> tuple[bool, bool]:
    """Whether a topic lacks positions or efforts, and whether its messages are not plain joint states."""
    measured = [
        any(np.isfinite(group.rows[field]).any() for group in groups if field in group.rows)
        for field in ("position", "effort")
    ]
    return not all(measured), groups[0].kind not in PLAIN


def _of_topics(
    source: Path, groups: Sequence[Group], robot: Robot, topics: list[str], joints: str | Sequence[str] | None
) -> tuple[list[Group], list[str]]:
    """Joint states on the stated topics."""
    known = _by_topic(groups)
    for topic in topics:
        if topic not in known:
            raise RecordingError(
                f"{source}: no joint states on {topic}. Topics with joint states: {', '.join(known)}; choose "
                "one by --topic TOPIC"
            )
    chosen = [group for group in groups if group.topic in topics]
    try:
        return chosen, find_joints(robot, names_in(chosen), joints, f"{source}")
    except RecordingError:
        # The error about all topics is more specific if none has them.
        names = find_joints(robot, names_in(groups), joints, f"{source}")
    missing = [name for name in names if name not in names_in(chosen)]
    others = [topic for topic, sharing in known.items() if set(missing) & set(names_in(sharing))]
    raise RecordingError(
        f"{source}: {' and '.join(topics)} has no joint {listed(missing)}, which {' and '.join(others)} has. "
        f"Leave --topic out, or name all: --topic {','.join([*topics, *others])}"
    )


def names_in(groups: Sequence[Group]) -> tuple[str, ...]:
    """Names of all joints in some messages."""
    return tuple(dict.fromkeys(name for group in groups for name in group.names))


def _by_topic(groups: Sequence[Group]) -> dict[str, list[Group]]:
    """Joint states of each topic, sorted by its name."""
    topics: dict[str, list[Group]] = {}
    for group in sorted(groups, key=lambda group: group.topic):
        topics.setdefault(group.topic, []).append(group)
    return topics


CLOCKS_AGREE = 0.05
"""Maximum difference between the latencies of two publishers on one robot [s]. Networks and schedulers delay
messages by some milliseconds; a larger difference is due to their clocks."""
SECOND = 1_000_000_000
"""Maximum time between two messages of a moving joint [ns]."""
BRIDGED = 2.5
"""Maximum gap between two samples for interpolation, in periods: one lost sample, with jitter."""
BRIDGED_TIME = 0.05
"""Gap that is always interpolated [s], since messages may arrive in bursts: a tenth of the period of 2 Hz,
above which arms hardly move."""


def parts_of(groups: Sequence[Group], names: Sequence[str]) -> list[Group]:
    """Joints of a robot, grouped by their messages; one part if there are messages with all joints."""
    complete = [group for group in groups if set(names) <= set(group.names)]
    sources = complete or groups
    sharing: dict[tuple[int, ...], list[str]] = {}
    for name in names:
        places = tuple(place for place, group in enumerate(sources) if name in group.names)
        sharing.setdefault(places, []).append(name)
    parts = [_merged([sources[k] for k in places], joints) for places, joints in sharing.items()]
    return [piece for part in parts for piece in _by_values(part)]


def _merged(groups: Sequence[Group], names: Sequence[str]) -> Group:
    """Some joints of several groups, in the order in which the bag received the messages."""
    received = np.concatenate([group.received for group in groups])
    order = np.argsort(received, kind="stable")
    rows = {}
    for field in dict.fromkeys(field for group in groups for field in group.rows):
        values = [np.full((len(group.received), len(names)), np.nan) for group in groups]
        for known, group in zip(values, groups, strict=True):
            if field in group.rows:
                known[:] = group.rows[field][:, [group.names.index(name) for name in names]]
        rows[field] = np.concatenate(values)[order]
    stamp = np.concatenate([group.stamp for group in groups])[order]
    topics = " and ".join(dict.fromkeys(group.topic for group in groups))
    return Group(topics, tuple(names), received[order], stamp, rows)


def _by_values(part: Group) -> list[Group]:
    """The part, or its division by messages with values if each board sends NaN for the others' joints."""
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
    return [_only(part, joints) for joints in pieces.values()]


def _only(part: Group, joints: Sequence[int]) -> Group:
    """Part with some of the joints, and only the messages that have values of them."""
    rows = {name: values[:, joints] for name, values in part.rows.items()}
    present = np.any([np.isfinite(values).any(axis=1) for values in rows.values()], axis=0)
    return replace(
        part,
        names=tuple(part.names[joint] for joint in joints),
        received=part.received[present],
        stamp=part.stamp[present],
        rows={name: values[present] for name, values in rows.items()},
    )


def clock_of(parts: Sequence[Group]) -> tuple[list[np.ndarray], list[str]]:
    """Times of each part, shape (t,) [ns], and a note if they are not the stamps in the messages.

    The stamps in the messages are preferred, since the network delays the times of the bag. If stamps are not
    set, do not change, or come from clocks that disagree, the times of the bag are used.
    """
    received, stamps = [part.received for part in parts], [part.stamp for part in parts]
    all_stamps = np.concatenate(stamps)
    if not all_stamps.any():
        return received, []  # usual, and no information is lost
    late = [float(np.median(part.received - part.stamp)) * 1e-9 for part in parts]
    reason = ""
    if any(_unset(stamp) for stamp in stamps):
        reason = f"{np.sum(all_stamps == 0)} of {len(all_stamps)} messages have no time stamp"
    elif any(len(stamp) > 1 and np.ptp(stamp) == 0 for stamp in stamps):
        reason = "the time stamps of the messages do not change"
    elif max(late) - min(late) > CLOCKS_AGREE:
        reason = f"the clocks of the publishers differ by {digits(max(late) - min(late))} s"
    if not reason:
        return stamps, []
    return received, [f"{reason}: times are those at which the bag received them"]


def _unset(stamp: np.ndarray) -> bool:
    """Whether stamps (t,) [ns] of zero were not set: a clock that starts at zero has only one."""
    zeros = int(np.sum(stamp == 0))
    return zeros > 1 or 0 < zeros < len(stamp) and int(stamp[stamp > 0].min()) > SECOND


def joined(source: str, parts: Sequence[Group], times: Sequence[np.ndarray]) -> tuple[Group, np.ndarray, str]:
    """Joints in different messages as one part at common times (t,) [ns], and a warning.

    `times` are those of each part, shape (t,) [ns]; `source` is the name of the bag in messages.
    """
    ordered = [np.unique(time) for time in times]
    periods = [_period(time) for time in ordered]
    slowest = int(np.argmax(periods))
    time, places = np.unique(times[slowest], return_index=True)
    common = (time >= max(known[0] for known in ordered)) & (time <= min(known[-1] for known in ordered))
    if common.sum() < 2:
        raise RecordingError(
            f"{source}: joints are in different messages that have no times in common: "
            f"{'; '.join(map(str, parts))}. Record all joints at the same time, with one clock"
        )
    time, places = time[common], places[common]
    fields = dict.fromkeys(field for part in parts for field in part.rows)
    together = Group(
        " and ".join(part.topic for part in parts),
        tuple(name for part in parts for name in part.names),
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
    return together, time, warning


def _period(time: np.ndarray) -> float:
    """Mean period of sorted times (t,) [ns]; infinite for fewer than two."""
    return float(np.ptp(time)) / (len(time) - 1) if len(time) > 1 else float("inf")


def _bridged(time: np.ndarray, known: np.ndarray, longest: float) -> np.ndarray:
    """Whether times (t,) are at a sample, or between two samples at most `longest` apart [ns]."""
    after = np.searchsorted(known, time)
    before = np.searchsorted(known, time, side="right") - 1
    inside = (before >= 0) & (after < len(known))
    span = known[np.minimum(after, len(known) - 1)] - known[np.maximum(before, 0)]
    return inside & (span <= longest)


def _distance(time: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Distance of each time to the nearest known time, shape (t,) [ns]."""
    after = np.clip(np.searchsorted(known, time), 1, len(known) - 1)
    return np.minimum(np.abs(known[after] - time), np.abs(time - known[after - 1]))


def _at(time: np.ndarray, known: np.ndarray, part: Group, field: str) -> np.ndarray:
    """A field of a part at other times, shape (t, n); NaN if samples are missing."""
    values = np.full((len(time), len(part.names)), np.nan)
    for joint, column in enumerate(part.rows[field].T if field in part.rows else ()):
        measured = np.isfinite(column)
        there, first = np.unique(known[measured], return_index=True)
        if len(there) < 2:
            continue
        column = column[measured][first]
        # Times are counted from the first sample, since a double cannot hold nanoseconds since 1970.
        since, wanted = (there - there[0]) * 1e-9, (time - there[0]) * 1e-9
        smooth = field == "position" and len(there) > 3
        row = CubicSpline(since, column)(wanted) if smooth else np.interp(wanted, since, column)
        longest = max(BRIDGED * _period(there), 1e9 * BRIDGED_TIME)
        values[:, joint] = np.where(_bridged(time, there, longest), row, np.nan)
    return values
