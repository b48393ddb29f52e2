"""Choice of the topics of a bag that hold the joints of a robot, and the names of the joints there."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ...arm.robot import Robot
from ...errors import RecordingError, listed
from ..tables.columns import find_joints
from .bag_reader import Group
from .joint_messages import JOINT_READERS, JSON

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
