"""Evidence that no diagnosis has a part in: a plain fit with one term and without it, on runs held out."""

import numpy as np

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model

from .known import Known
from .sets import Runs


def shown(known: Known, model: Model, runs: Runs) -> str:
    """Residual held out of the joint without and with the effect, per run; nothing if no fit shows it."""
    if known.term is None:
        return ""
    joint = known.joints[0]
    with_it = model + known.term(model.robot.joints[joint])
    before, after = (held_out(one, runs, joint) for one in (model, with_it))
    unit = model.robot.unit(joint, "N m")
    change = 100 * (np.linalg.norm(after) / np.linalg.norm(before) - 1)
    lists = " → ".join(", ".join(f"{value:.3g}" for value in some) for some in (before, after))
    return f"residual held out without and with it: {lists} {unit} ({change:+.0f} %)"


def held_out(model: Model, runs: Runs, joint: int) -> np.ndarray:
    """Root mean square of a joint's residual in each run held out in which it moves, driven (h,)."""
    fitted = [run for role, run in runs if role != HELD_OUT]
    fit = identify(fitted, [run for role, run in runs if role == HELD_OUT], model=model)
    slides = [one for one in fit.validation if one.weight[:, joint].any()]
    return np.array([one.residual_rms[joint] for one in slides])
