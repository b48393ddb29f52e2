"""Small runs of a small arm, and where the real ones lie."""

import gzip
import os
from pathlib import Path

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects import RigidBody
from exidyn.identification.model import Model

BESIDE = Path(__file__).parents[4] / "shared"
DATA = Path(os.environ.get("EXIDYN_DATA", BESIDE / "data"))

TIME = np.arange(200) * 0.004


def model(joints: int = 2, **options) -> Model:
    kinematics = pin.Model()
    for place in range(joints):
        index = kinematics.addJoint(place, pin.JointModelRZ(), pin.SE3.Identity(), f"axis{place + 1}")
        kinematics.appendBodyToJoint(index, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    return Model(Robot("small", kinematics, **options), (RigidBody(),))


def motion(joints: int = 2) -> np.ndarray:
    return 0.5 * np.sin(np.outer(TIME, 3.0 + np.arange(joints)))


def noise(joints: int = 2, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(len(TIME), joints))


def require(recording, atol: float | None = None, **expected: np.ndarray) -> None:
    """Signals by name, and the `time` of the positions, are as expected: exactly, or to a tolerance."""
    for name, values in expected.items():
        signal = recording.signals["position" if name == "time" else name]
        actual = signal.time if name == "time" else signal.values
        if atol is None:
            assert np.array_equal(actual, values), name
        else:
            np.testing.assert_allclose(actual, values, atol=atol, err_msg=name)


def table(path: Path, header: str, *columns: np.ndarray, separator: str = ",", time=TIME) -> Path:
    rows = np.column_stack([time, *columns])
    lines = [header, *(separator.join(map(repr, row)) for row in rows.tolist())]
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "wt") as file:
        file.write("\n".join(lines) + "\n")
    return path
