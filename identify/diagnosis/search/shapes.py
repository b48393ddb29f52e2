"""Shapes that an earlier search has found, asked for again beside the grid.

A grid is too coarse for a resonance that is hardly damped: between its places none comes near.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..questions.candidate import Candidate
from .selected import Selected


class Shaped(NamedTuple):
    """A hypothesis in the shape that was found.

    Attributes:
        effect: Name in the vocabulary.
        joints: From 0.
        kind: As of the candidate.
        shape: Numbers that were searched.
    """

    effect: str
    joints: tuple[int, ...]
    kind: str
    shape: dict[str, float]


def shapes_of(found: Sequence[Selected]) -> list[Shaped]:
    """Of findings, those of a shape."""
    every = [one.answer.candidate for one in found]
    return [
        Shaped(*one.key, {name: float(one.shape[name]) for name in one.bounds}) for one in every if one.bounds
    ]


def asked_again(every: Sequence[Candidate], before: Sequence[Shaped]) -> Iterator[Candidate]:
    """Candidates in the shapes found before, those that can be asked for in this model."""
    by_key = {one.key: one for one in every if one.bounds and one.reshaped is not None}
    for one in before:
        alike = by_key.get((one.effect, one.joints, one.kind))
        if alike is not None and set(one.shape) == set(alike.bounds):
            assert alike.reshaped is not None
            yield alike.reshaped(one.shape)
