"""A simulated KR270 whose truth is known, and what was identified of it beside that truth."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from exidyn.identify.effects import Payload, known_parameters
from exidyn.identify.fit import Fit
from exidyn.identify.model import Model
from exidyn.identify.robot_file import model_text, read_model
from exidyn.identify.text_table import at_point, digits, table

MASS = 175.0
"""Payload [kg], as in the paper; nothing but this is told to the identification."""

BODY = known_parameters(MASS, com=(0.05, 0.03, -0.22), inertia=(8.0, 0.1, 0.2, 9.0, 0.3, 7.0))
"""What the payload really is: a tool some twenty centimetres in front of the flange, which looks along -z."""

GAIN_ERROR = 0.1
"""By how much the drive gains are believed too large; the paper found data sheets 8 to 19 % off."""


@dataclass(frozen=True)
class Example:
    """An arm as it is, and as it is believed to be.

    Attributes:
        truth: The arm as it is, its beliefs being true.
        believed: The same with drive gains that are too large.
    """

    truth: Model
    believed: Model

    def files(self) -> Mapping[str, str]:
        """Robot files: as believed, as it is, and as it is with its payload; name -> text."""
        loaded = self.truth + Payload("L", BODY)
        models = {"believed": self.believed, "truth": self.truth, "truth-loaded": loaded}
        return {f"{name}.toml": model_text(model) for name, model in models.items()}

    def write(self, folder: Path) -> None:
        """Write the robot files into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in self.files().items():
            (folder / name).write_text(text, encoding="utf-8")


def make_example(robot: str = "kr270") -> Example:
    """The arm as it is described, and one whose drive gains are believed too large by `GAIN_ERROR`."""
    truth = read_model(robot)
    gain = (1 + GAIN_ERROR) * truth.robot.drive_gain
    wrong = replace(truth.robot, drive_gain=gain, drive_gain_tolerance=GAIN_ERROR)
    return Example(truth, replace(truth, robot=wrong))


def comparison(fit: Fit, truth: Model) -> str:
    """Identified drive gains and spring beside the true ones."""
    joints, estimate = truth.robot.joints, fit.estimate
    rows = [
        (f"drive gain {joint}", "N m/A", *numbers)
        for joint, *numbers in zip(
            joints,
            truth.robot.drive_gain,
            fit.model.robot.drive_gain,
            estimate.gain,
            estimate.gain_std,
            strict=True,
        )
    ]
    true = dict(zip(truth.names, truth.believed_values, strict=True))
    for name, meaning in (("Kr", "spring stiffness K_r"), ("K0", "spring preload K_0")):
        if name in fit.names:
            row = fit.names.index(name)
            believed = fit.believed[0][row]
            rows.append(
                (meaning, fit.base.units[row], true[name], believed, estimate.values[row], estimate.std[row])
            )
    real, believed, found, std = np.array([row[2:] for row in rows]).T
    texts = [at_point([digits(v) for v in column]) for column in (real, believed, found)]
    for column in (100 * (found / real - 1), 100 * std / np.abs(found), (found - real) / std):
        texts.append([f"{v:.3f}" for v in column])
    head = ["", "unit", "true", "believed", "identified", "error %", "std %", "error/std"]
    labels = ([row[0] for row in rows], [row[1] for row in rows])
    return "\n".join(table(head, [list(row) for row in zip(*labels, *texts, strict=True)], left=(0, 1)))
