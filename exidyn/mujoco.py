"""What was found, in your own MuJoCo simulation: `from exidyn.mujoco import attach`."""

import warnings
from pathlib import Path
from typing import Any

from exidyn.acquire.files.given_runs import read_arm
from exidyn.identification.diagnosis.words.naming import effect_words
from exidyn.identification.errors import RobotWarning
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identified import identified
from exidyn.identification.in_mujoco.attached import Attached
from exidyn.identification.model import Model
from exidyn.identification.robot_files.finding_rows import parse_findings
from exidyn.identification.robot_files.toml_fields import parse_toml, read_text

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
        rows = parse_findings(parse_toml(read_text(path), str(path)))
        if absent := ", ".join(effect_words(row.effect) for row in rows if not row.in_model):
            words = f"{path}: not attached, since no model holds it: {absent}"
            warnings.warn(words, RobotWarning, stacklevel=3)
    return arm
