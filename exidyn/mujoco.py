"""Identified effects in your own MuJoCo simulation: `from exidyn.mujoco import attach`."""

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
from exidyn.identification.robot_files.effect_rows import parse_findings
from exidyn.identification.robot_files.toml_fields import parse_toml, read_text

__all__ = ["Attached", "attach"]


def attach(
    model: Any, data: Any, arm: Fit | Model | Path | str, *, payload: str = "", temperature: Any = 25.0
) -> Attached:
    """Add all effects that MJCF cannot express to the steps of a model, with the formulas of the fit.

    Args:
        model: `MjModel` of your file after `exidyn export --patch`.
        data: An `MjData` of the model; the effects also act with any other `MjData` of the model.
        arm: Fit or model, or the path of fit.json, found.toml or another robot file.
        payload: Name of the payload that is part of the last link; empty for none.
        temperature: Temperature of the joints, one value or one per joint [degC].

    Warns:
        RobotWarning: The arm has elastic gears or backlash, or found.toml lacks some of the findings.

    Raises:
        RobotError: The model differs from the arm, or an effect cannot be attached; the message names it.
    """
    if isinstance(arm, Fit):
        arm = identified(arm)
    attached = arm if isinstance(arm, Model) else _read(Path(arm))
    if attached.gears:
        joints = ", ".join(dict.fromkeys(gear.joint for gear in attached.gears))
        words = f"not attached: elasticity or backlash of the gears of {joints}; exidyn gap writes those"
        warnings.warn(words, RobotWarning, stacklevel=2)
    return Attached(model, data, attached, payload, temperature)


def _read(path: Path) -> Model:
    """Read the arm of a file; warn of findings that it does not contain, such as a hose."""
    arm = read_arm(str(path))
    if path.suffix == ".toml" and path.is_file():
        rows = parse_findings(parse_toml(read_text(path), str(path)))
        if absent := ", ".join(effect_words(row.effect) for row in rows if not row.in_model):
            words = f"{path}: not attached because no model can hold it: {absent}"
            warnings.warn(words, RobotWarning, stacklevel=3)
    return arm
