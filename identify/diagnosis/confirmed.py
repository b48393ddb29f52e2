"""Confirmed: which findings stand once runs held out, the noise and what is left have been looked at."""

from collections.abc import Sequence

import numpy as np

from ..model import Model
from .candidate import Candidate, Thinned
from .driven import Driven
from .held_out import HeldOut
from .remainder import Left, greatest, rms
from .search import CERTAIN_ODDS, Found, Searched

Features = Sequence[tuple[Candidate, Thinned]]
ONCE = ("contact_event",)
"""What happens in one run and says nothing of another."""
NEGLIGIBLE = 0.1
"""Torque over the noise floor below which an effect, be it real, changes a residual by half a per cent."""
MOSTLY = 0.6
"""Share of the evidence on a joint that its findings must account for to be given their name: two thirds."""


def confirmed(
    model: Model, found: Searched, held_out: Sequence[Driven], features: Features, noise: np.ndarray
) -> Searched:
    """Without findings that runs held out speak against, that are negligible, or mostly something else.

    Args:
        model: As believed.
        found: What a search has come to.
        held_out: Runs that were not fitted.
        features: Of the runs that were.
        noise: Noise floor of each joint's torque, shape (n,) [N m].
    """
    pairs = list(zip(found.found, gained(found, HeldOut.of(model, found, held_out)), strict=True))
    good = [k for k, (one, gain) in enumerate(pairs) if _stands(one, gain) and _matters(found, one, noise)]
    found = found if len(good) == len(pairs) else found.keeping(good)
    if not found.found:
        return found
    left = greatest(found.solution, features, noise)
    named = [k for k, one in enumerate(found.found) if not _mostly_else(found, one, left)]
    return found if len(named) == len(found.found) else found.keeping(named)


def gained(found: Searched, held_out: HeldOut | None) -> list[float]:
    """What each finding gains on runs held out, see `HeldOut.gain`; NaN without any."""
    if held_out is None:
        return [float("nan")] * len(found.found)
    return [held_out.gain(found, place) for place in range(len(found.found))]


def _stands(one: Found, gain: float) -> bool:
    """Whether it is still credible with what runs held out say."""
    if not np.isfinite(gain) or gain > 0 or one.hypothesis.candidate.effect in ONCE:
        return True
    return one.odds + 0.5 * gain > CERTAIN_ODDS


def _matters(found: Searched, one: Found, noise: np.ndarray) -> bool:
    """Whether its torque is worth a name in any run on any joint."""
    columns = one.hypothesis.columns
    weight = found.rows.weight[:, columns.joints]
    torques = [rms(one.hypothesis.torque[rows], weight[rows]) for rows in found.rows.runs]
    return bool(np.any(np.max(torques, axis=0) > NEGLIGIBLE * noise[columns.joints]))


def _mostly_else(found: Searched, one: Found, left: Sequence[Left]) -> bool:
    """Whether what is left on the joint that it moves most is no less than what it explains."""
    strength = (
        np.sqrt(np.mean(one.hypothesis.torque**2, axis=0))
        / found.solution.whitening.scale[one.hypothesis.columns.joints]
    )
    joint = int(one.hypothesis.columns.joints[np.argmax(strength)])
    rest = max((other.evidence for other in left if other.joint == joint), default=0.0)
    named = sum(
        max(other.hypothesis.evidence, 0.0)
        for other in found.found
        if joint in other.hypothesis.columns.joints
    )
    return bool(named < MOSTLY * (named + rest))
