"""A simulated KR270 whose truth is known, and the robot files of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from exidyn.identify.effects import Payload, known_parameters
from exidyn.identify.model import Model
from exidyn.identify.robot_files.robot_text import model_text

MASS = 175.0
"""Payload [kg], as in the paper."""

CENTRE = (0.05, 0.03, -0.22)
"""Its centre of mass [m]: a tool some twenty centimetres in front of the flange, which looks along -z."""

INERTIA = (8.0, 0.1, 0.2, 9.0, 0.3, 7.0)
"""Its moments about that, XX, XY, XZ, YY, YZ, ZZ [kg m^2]."""

BODY = known_parameters(MASS, CENTRE, INERTIA)
"""What the payload really is, by parameter; what is stated about it may differ."""

NOMINAL, TRUTH, LOADED = "robot.toml", "truth.toml", "truth-loaded.toml"
"""Files of the arm nominal, as it is, and as it is with its payload."""


@dataclass(frozen=True)
class ExampleArm:
    """An arm as it is, and nominal.

    Attributes:
        truth: The arm as it is, its priors being true.
        nominal: The same with something wrong or missing.
    """

    truth: Model
    nominal: Model

    def files(self) -> Mapping[str, str]:
        """Robot files, name -> text."""
        models = {NOMINAL: self.nominal, TRUTH: self.truth, LOADED: self.truth + Payload("L", BODY)}
        return {name: model_text(model) for name, model in models.items()}

    def write(self, folder: Path) -> None:
        """Write the robot files into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in self.files().items():
            (folder / name).write_text(text, encoding="utf-8")
