"""Result of the balancer's example from its files: truth, findings and residuals."""

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
"""File of the model with the findings."""
EFFECT = "spring_balancer"
"""Name of the concealed effect in a diagnosis."""
PLACES = 200
"""Number of positions over the joint's range at which springs are compared, half a degree apart."""


class Spring(NamedTuple):
    """A balancer with its coefficients from the file of a model or a diagnosis."""

    effect: SpringBalancer  # joint and geometry
    stiffness: float  # k_r [N/m]
    preload: float  # k_0 [N]

    def as_long_as(self, other: "Spring") -> "Spring":
        """A spring of equal torque with the other's `d21`; torque depends only on the length ratio."""
        scale = other.effect.d21 / self.effect.d21
        effect = replace(self.effect, d21=other.effect.d21, d22=scale * self.effect.d22)
        return Spring(effect, self.stiffness / scale**2, self.preload / scale)

    def in_place_of(self, other: "Spring", robot: Robot) -> "Spring":
        """The spring with this one's lengths and angle whose torque is closest to the other's."""
        columns = [self._replace(stiffness=a, preload=b).torque(robot) for a, b in ((1.0, 0.0), (0.0, 1.0))]
        stiffness, preload = np.linalg.lstsq(np.transpose(columns), other.torque(robot), rcond=None)[0]
        return Spring(self.effect, float(stiffness), float(preload))

    def torque(self, robot: Robot) -> np.ndarray:
        """Torque that relieves the motor over the joint's range, shape (`PLACES`,) [N m]."""
        joint, limits = robot.index(self.effect.joint), robot.limits
        position, still = np.zeros((2, PLACES, robot.dof))
        position[:, joint] = np.linspace(limits.position_lower[joint], limits.position_upper[joint], PLACES)
        columns = self.effect.regressor(robot, Motion.of(np.arange(float(PLACES)), position, still, still))
        return -columns[:, joint] @ [self.stiffness, self.preload]


@dataclass(frozen=True)
class Result:
    """Truth, findings, and residuals of the held-out run."""

    folder: Path  # folder of the files
    robot: Robot  # robot of the true arm
    concealed: Spring  # the true spring
    findings: list[dict[str, Any]]  # findings in diagnosis.json
    # Root mean square of each joint over its noise, name -> shape (n,): torque "nominal", "identified"
    # without the spring and "found"; current "simulated before" and "simulated after".
    residuals: dict[str, np.ndarray]

    @classmethod
    def read(cls, folder: Path) -> "Result":
        """Read the files that the steps wrote."""
        truth = read_model(str(folder / TRUTH))
        diagnosis = _table(folder / "exidyn-diagnosis" / "diagnosis.json")
        fit = _table(folder / "exidyn-fit" / "fit.json")
        residuals = {
            "nominal": _over(diagnosis["torque_rms_before"], diagnosis["noise"]),
            "identified": np.array(fit["validation"][0]["over_noise"]),
            "found": _over(diagnosis["torque_rms_after"], diagnosis["noise"]),
        }
        for when in ("before", "after"):
            effort = list(_table(folder / f"compare-{when}.json")["mismatch"].values())[-1]
            residuals[f"simulated {when}"] = _over(effort["rms"], effort["noise"])
        return cls(folder, truth.robot, _spring(truth), diagnosis["findings"], residuals)

    @property
    def joint(self) -> int:
        """Index of the joint that carries the spring, from 0."""
        return self.robot.index(self.concealed.effect.joint)

    @property
    def right(self) -> dict[str, Any] | None:
        """The finding that names effect and joint of the spring; None if there is none."""
        return next((finding for finding in self.findings if self._names_spring(finding)), None)

    @property
    def wrong(self) -> list[dict[str, Any]]:
        """Findings that do not name the concealed spring."""
        return [finding for finding in self.findings if not self._names_spring(finding)]

    def _names_spring(self, finding: dict[str, Any]) -> bool:
        return (finding["effect"], finding["joints"]) == (EFFECT, [self.joint + 1])

    @property
    def estimate(self) -> Spring | None:
        """The estimated spring with the lengths of the diagnosis; None if it was not named."""
        if self.right is None:
            return None
        values = {name: quantity["value"] for name, quantity in self.right["parameters"].items()}
        effect = replace(self.concealed.effect, d21=1.0, d22=values[LEVERS], phi=values["phi"])
        return Spring(effect, values[STIFFNESS], values[PRELOAD])


def _spring(model: Model) -> Spring:
    values = dict(zip(model.names, map(float, model.nominal_values), strict=True))
    effect = next(effect for effect in model.effects if isinstance(effect, SpringBalancer))
    return Spring(effect, values["Kr"], values["K0"])


def _table(path: Path) -> dict[str, Any]:
    table: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return table


def _over(rms: list[float | None], noise: list[float | None]) -> np.ndarray:
    """Ratios, with NaN where the file has null."""
    return np.array(rms, float) / np.array(noise, float)
