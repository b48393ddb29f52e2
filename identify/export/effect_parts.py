"""Effects of a portable model, split into the parts that act on single joints."""

from dataclasses import replace

import numpy as np

from ..effects import Effect
from ..effects.effect import JointEffect
from .portable import Portable

Pair = tuple[Effect, np.ndarray]
"""An effect and its parameters (p,)."""


def joint_effects(portable: Portable, kind: type[JointEffect], place: int) -> list[Pair]:
    """Effects of a kind on one joint, each split off from those on other joints."""
    return [
        pair
        for effect, values in portable.others
        if isinstance(effect, kind)
        for pair in _apart(portable, effect, values)
        if pair[0].parameter_joints(portable.robot)[0] == place
    ]


def _apart(portable: Portable, effect: Effect, values: np.ndarray) -> list[Pair]:
    parts = effect.apart(portable.robot)
    return list(zip(parts, np.split(values, len(parts)), strict=True))


def without_effect(portable: Portable, part: Effect, values_of_part: np.ndarray) -> Portable:
    """The model in which one part of an effect has other values (p,); without it if they are zero."""
    others: list[Pair] = []
    for effect, values in portable.others:
        pieces = _apart(portable, effect, values) if type(effect) is type(part) else []
        if part not in [piece for piece, _ in pieces]:
            others.append((effect, values))
            continue
        pieces = [(piece, values_of_part if piece == part else share) for piece, share in pieces]
        others += [(piece, share) for piece, share in pieces if np.any(share)]
    return replace(portable, others=tuple(others))
