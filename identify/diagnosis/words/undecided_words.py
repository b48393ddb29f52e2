"""What is there and has no certain name, in one sentence each."""

from collections.abc import Sequence

from ..findings.finding import Alternative, Finding
from .naming import effect_words, joined, joint_words, lower


def undecided_sentence(finding: Finding, joints: Sequence[str], settled: str = "") -> str:
    """Where it is, what it may be with which probability, and what would settle it.

    Args:
        finding: With its alternatives.
        joints: Names of the robot's joints.
        settled: The run that would settle it, in words or as a command; empty if none is known.
    """
    where = joined([joint_words(joint, joints) for joint in finding.joints]) if finding.joints else "The arm"
    every = [_possible(one, finding, joints) for one in possible(finding)]
    text = f"{where}: something is missing that is {joined(every, 'or')}"
    text += ", but only one joint shows that" if finding.alone else ""
    text += ", or acts like it: as much is left there that has no name" if finding.unnamed else ""
    return f"{text}; what would settle it: {settled}." if settled else f"{text}."


def possible(finding: Finding) -> list[Finding | Alternative]:
    """The finding and its alternatives, the most probable first: it need not be the one that was fitted."""
    every: tuple[Finding | Alternative, ...] = (finding, *finding.alternatives)
    return sorted(every, key=lambda one: -one.probability)


def _possible(one: Finding | Alternative, finding: Finding, joints: Sequence[str]) -> str:
    """An effect with its probability, and its joint where that is another."""
    name, percent = effect_words(one.effect), f"{100 * one.probability:.2g} %"
    if one.joints == finding.joints:
        return f"{name} ({percent})"
    where = joined([lower(joint_words(joint, joints)) for joint in one.joints]) if one.joints else "the arm"
    return f"{name} of {where} ({percent})"
