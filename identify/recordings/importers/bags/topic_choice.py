"""Which topics of a bag hold the joints of a robot, and what the joints are called there."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ....arm.robot import Robot
from ....errors import RecordingError, listed
from ..tables.columns import find_joints
from .bag_reader import Group
from .joint_messages import JOINT_READERS, JSON

PLAIN = (next(iter(JOINT_READERS)), JSON)
"""Types of messages that are joint states and nothing else; they are asked before others."""
USUAL = "/joint_states"
"""Topic that is taken where several have all joints."""


def choose_topics(
    source: Path,
    groups: Sequence[Group],
    robot: Robot,
    topic: str | None = None,
    joints: str | Sequence[str] | None = None,
) -> tuple[list[Group], list[str]]:
    """The joint states of a robot, and what its joints are called in them.

    Args:
        source: What errors call the bag.
        groups: All joint states of the bag.
        robot: The robot.
        topic: Topic of the joint states, or several with commas; by default the one that has all joints, or
            all topics that have any of them.
        joints: What the joints are called in the bag: one name a joint, or a pattern such as "left_{joint}".

    Raises:
        RecordingError: The bag does not have such a topic or joint, or has a joint on several topics.
    """
    if topic is not None:
        return _of_topics(source, groups, robot, topic.split(","), joints)
    names = find_joints(robot, names_in(groups), joints, f"{source}")
    complete = [name for name in _topics(groups) if set(names) <= set(names_in(_on(groups, [name])))]
    if complete:
        return _on(groups, [_best(source, groups, complete)]), names
    plain = [group for group in groups if group.kind in PLAIN]
    sources = plain if set(names) <= set(names_in(plain)) else list(groups)
    for name in names:
        having = [topic for topic in _topics(sources) if name in names_in(_on(sources, [topic]))]
        if len(having) > 1:
            raise RecordingError(
                f"{source}: no topic has all joints, and '{name}' is on {' and '.join(having)}; choose the "
                "topics of all joints by --topic TOPIC,TOPIC"
            )
    return [group for group in sources if set(names) & set(group.names)], names


def _best(source: Path, groups: Sequence[Group], complete: Sequence[str]) -> str:
    """The topic that is taken of several with all joints: one with efforts, and of plain joint states.

    Raises:
        RecordingError: Several are as good, and none is the usual one.
    """
    ranks = {topic: _rank(_on(groups, [topic])) for topic in complete}
    best = [topic for topic, rank in ranks.items() if rank == min(ranks.values())]
    if len(best) > 1 and USUAL not in best:
        raise RecordingError(
            f"{source}: several topics have the robot's joints. Topics with joint states: {', '.join(best)}; "
            "choose one by --topic TOPIC"
        )
    return best[0] if len(best) == 1 else USUAL


def _rank(groups: Sequence[Group]) -> tuple[bool, bool]:
    """Whether a topic lacks positions or efforts, and whether its messages are others than joint states."""
    measured = [
        any(np.isfinite(group.rows[field]).any() for group in groups if field in group.rows)
        for field in ("position", "effort")
    ]
    return not all(measured), groups[0].kind not in PLAIN


def _of_topics(
    source: Path, groups: Sequence[Group], robot: Robot, topics: list[str], joints: str | Sequence[str] | None
) -> tuple[list[Group], list[str]]:
    """The joint states on topics that are named.

    Raises:
        RecordingError: One is not there, or they lack a joint; the message names the topic that has it.
    """
    there = _topics(groups)
    for topic in topics:
        if topic not in there:
            raise RecordingError(
                f"{source}: no joint states on {topic}. Topics with joint states: {', '.join(there)}; choose "
                "one by --topic TOPIC"
            )
    chosen = _on(groups, topics)
    try:
        return chosen, find_joints(robot, names_in(chosen), joints, f"{source}")
    except RecordingError:
        names = find_joints(
            robot, names_in(groups), joints, f"{source}"
        )  # whose error says more if none has them
    missing = [name for name in names if name not in names_in(chosen)]
    others = [topic for topic in there if set(missing) & set(names_in(_on(groups, [topic])))]
    raise RecordingError(
        f"{source}: {' and '.join(topics)} has no joint {listed(missing)}, which {' and '.join(others)} has. "
        f"Leave --topic out, or name all: --topic {','.join([*topics, *others])}"
    )


def _on(groups: Sequence[Group], topics: Sequence[str]) -> list[Group]:
    return [group for group in groups if group.topic in topics]


def names_in(groups: Sequence[Group]) -> tuple[str, ...]:
    """Names of all joints in some messages."""
    return tuple(dict.fromkeys(name for group in groups for name in group.names))


def _topics(groups: Sequence[Group]) -> list[str]:
    return sorted({group.topic for group in groups})
