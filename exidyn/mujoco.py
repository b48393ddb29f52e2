"""What was found, in your own MuJoCo simulation: `from exidyn.mujoco import attach`."""

from pathlib import Path
from typing import Any

from exidyn.acquire.files.given_runs import read_arm
from exidyn.identify.fit.fit import Fit
from exidyn.identify.fit.identified import identified
from exidyn.identify.in_mujoco.attached import Attached
from exidyn.identify.model import Model

__all__ = ["Attached", "attach"]


def attach(
    model: Any, data: Any, arm: Fit | Model | Path | str, *, payload: str = "", temperature: Any = 25.0
) -> Attached:
    """Have every effect that MJCF lacks act in a model's steps, by the formulas of the fit.

    Args:
        model: `MjModel` of your file, what was found written into it by `exidyn export --patch`.
        data: An `MjData` of it. Effects act with every other one of this model too.
        arm: fit.json, found.toml or another robot file, or the value of one.
        payload: Name of the payload that is part of the last link; empty for none.
        temperature: Of the joints, one number or one a joint [degC].

    Raises:
        RobotError: The model differs from the arm, or an effect cannot be attached; the message names it.
    """
    if isinstance(arm, Fit):
        arm = identified(arm)
    found = arm if isinstance(arm, Model) else read_arm(str(arm))
    return Attached(model, data, found, payload, temperature)
