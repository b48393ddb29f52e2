"""What was found, in your own MuJoCo simulation: `from exidyn.mujoco import attach`."""

import warnings
from pathlib import Path
from typing import Any

from exidyn.acquire.files.diagnosis_files import ABSENT
from exidyn.acquire.files.given_runs import read_arm
from exidyn.identification.errors import RobotWarning
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identified import identified
from exidyn.identification.in_mujoco.attached import Attached
from exidyn.identification.model import Model
from exidyn.quoting import hash_comment

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

    Warns:
        RobotWarning: The arm has elastic gears or backlash, or found.toml lacks some of what was found.

    Raises:
        RobotError: The model differs from the arm, or an effect cannot be attached; the message names it.
    """
    if isinstance(arm, Fit):
        arm = identified(arm)
    found = arm if isinstance(arm, Model) else _read(Path(arm))
    if found.gears:
        joints = ", ".join(dict.fromkeys(gear.joint for gear in found.gears))
        words = f"not attached: gears that give way or have play, of {joints}; exidyn gap writes those"
        warnings.warn(words, RobotWarning, stacklevel=2)
    return Attached(model, data, found, payload, temperature)


def _read(path: Path) -> Model:
    """The arm of a file; warns of findings that it does not hold, such as a hose."""
    arm = read_arm(str(path))
    if path.suffix == ".toml" and path.is_file():
        first = path.read_text(encoding="utf-8").partition("\n")[0]
        head = hash_comment(ABSENT)
        if first.startswith(head):
            words = f"{path}: not attached, since no model holds it: {first.removeprefix(head)}"
            warnings.warn(words, RobotWarning, stacklevel=3)
    return arm
