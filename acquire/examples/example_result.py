"""Results in the files of the balancer's example: what was concealed, what was named, what is left."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Robot
from exidyn.identification.diagnosis.candidates.springs import LEVERS, PRELOAD, STIFFNESS
from exidyn.identification.effects import SpringBalancer
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model

from .example_arm import TRUTH

IMPROVED = "improved.toml"
"""File of the model with what was found."""
EFFECT = "spring_balancer"
"""What is concealed, in the words of a diagnosis."""
PLACES = 200
"""Positions over a joint's range at which two springs are compared: half a degree apart."""


class Spring(NamedTuple):
    """A balancer with its coefficients, as the file of a model or a diagnosis has them.

    Attributes:
        effect: Joint and geometry.
        stiffness: K_r [N/m].
        preload: K_0 [N].
    """

    effect: SpringBalancer
    stiffness: float
    preload: float

    def as_long_as(self, other: "Spring") -> "Spring":
        """The same torque by a spring with the other's `d21`: torque only shows the ratio of the lengths."""
        scale = other.effect.d21 / self.effect.d21
        effect = replace(self.effect, d21=other.effect.d21, d22=scale * self.effect.d22)
        return Spring(effect, self.stiffness / scale**2, self.preload / scale)

    def in_place_of(self, other: "Spring", robot: Robot) -> "Spring":
        """The other's torque, as near as the lengths and the angle of this one come to it."""
        columns = [self._replace(stiffness=a, preload=b).torque(robot) for a, b in ((1.0, 0.0), (0.0, 1.0))]
        stiffness, preload = np.linalg.lstsq(np.transpose(columns), other.torque(robot), rcond=None)[0]
        return Spring(self.effect, float(stiffness), float(preload))

    def torque(self, robot: Robot) -> np.ndarray:
        """What it takes from the motor over the range of its joint, shape (`PLACES`,) [N m]."""
        joint, limits = robot.index(self.effect.joint), robot.limits
        position, still = np.zeros((2, PLACES, robot.dof))
        position[:, joint] = np.linspace(limits.position_lower[joint], limits.position_upper[joint], PLACES)
        columns = self.effect.regressor(robot, Motion.of(np.arange(float(PLACES)), position, still, still))
        return -columns[:, joint] @ [self.stiffness, self.preload]


@dataclass(frozen=True)
class Result:
    """Truth, findings, and what is left on the run held out.

    Attributes:
        folder: Where the files are.
        robot: The arm.
        concealed: The true spring.
        findings: Those of diagnosis.json.
        left: Root mean square over noise of each joint, name -> shape (n,): torque "nominal", "identified"
            without the spring and "found"; current "simulated before" and "simulated after".
    """

    folder: Path
    robot: Robot
    concealed: Spring
    findings: list[dict[str, Any]]
    left: dict[str, np.ndarray]

    @classmethod
    def read(cls, folder: Path) -> "Result":
        """Out of the files that the steps wrote."""
        truth = read_model(str(folder / TRUTH))
        diagnosis = _table(folder / "exidyn-diagnosis" / "diagnosis.json")
        fit = _table(folder / "exidyn-fit" / "fit.json")
        left = {
            "nominal": _over(diagnosis["torque_rms_before"], diagnosis["noise"]),
            "identified": np.array(fit["validation"][0]["over_noise"]),
            "found": _over(diagnosis["torque_rms_after"], diagnosis["noise"]),
        }
        for when in ("before", "after"):
            effort = list(_table(folder / f"compare-{when}.json")["mismatch"].values())[-1]
            left[f"simulated {when}"] = _over(effort["rms"], effort["noise"])
        return cls(folder, truth.robot, _spring(truth), diagnosis["findings"], left)

    @property
    def joint(self) -> int:
        """That of the spring, from 0."""
        return self.robot.index(self.concealed.effect.joint)

    @property
    def right(self) -> dict[str, Any] | None:
        """The finding that names it, effect and joint; None if there is none."""
        return next((one for one in self.findings if self._names_it(one)), None)

    @property
    def wrong(self) -> list[dict[str, Any]]:
        """Findings of what is not concealed."""
        return [one for one in self.findings if not self._names_it(one)]

    def _names_it(self, finding: dict[str, Any]) -> bool:
        return (finding["effect"], finding["joints"]) == (EFFECT, [self.joint + 1])

    @property
    def found(self) -> Spring | None:
        """The spring that was found, its lengths as it has them."""
        if self.right is None:
            return None
        known = {name: quantity["value"] for name, quantity in self.right["parameters"].items()}
        effect = replace(self.concealed.effect, d21=1.0, d22=known[LEVERS], phi=known["phi"])
        return Spring(effect, known[STIFFNESS], known[PRELOAD])


def _spring(model: Model) -> Spring:
    values = dict(zip(model.names, map(float, model.nominal_values), strict=True))
    effect = next(one for one in model.effects if isinstance(one, SpringBalancer))
    return Spring(effect, values["Kr"], values["K0"])


def _table(path: Path) -> dict[str, Any]:
    table: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return table


def _over(rms: list[float | None], noise: list[float | None]) -> np.ndarray:
    """Ratios, NaN where a file has null."""
    return np.array(rms, float) / np.array(noise, float)
