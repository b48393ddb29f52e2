"""Rivals of speed: FIGAROH's own code path on arrays, and the least a regressor can cost from Python.

FIGAROH is used as in its documentation: `load_robot`, a YAML file in its unified format, and a subclass of
its `BaseIdentification` that returns the recording as a `TrajectoryData`. Filter, derivatives, regressor,
base parameters, solution and standard deviations are all FIGAROH's. It is optional: `why_absent()` names in
one sentence what to install.
"""

import contextlib
import io
import json
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin


class Settings(NamedTuple):
    """What a user of FIGAROH chooses."""

    cutoff: float = 100.0  # Of the low-pass filter on positions; FIGAROH's default is 100 [Hz]
    decimation: int = 10  # One row kept of so many; FIGAROH's default is 10, and 1 keeps all
    edge: float = 0.0  # Left out at both ends after filtering [s]

    @classmethod
    def best(cls, decimation: int = 10) -> "Settings":
        """Settings that fit a motion below 1 Hz with encoder noise well.

        10 Hz leaves ten harmonics of the motion and stops the noise of the acceleration; one second is ten
        periods of that filter, after which its start is forgotten.
        """
        return cls(cutoff=10.0, decimation=decimation, edge=1.0)


def why_absent() -> str:
    """Sentence with the reason why FIGAROH cannot be compared with; empty where it can."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # two of its dependencies register the same converters
            import figaroh.identification.base_identification  # noqa: F401
    except ImportError as missing:
        return f"FIGAROH is left out of the comparison ({missing}); pip install 'exidyn[bench]' brings it."
    return ""


class FigarohArm:
    """An arm loaded by FIGAROH, with viscous and Coulomb friction, rotor inertia and offset at each joint."""

    def __init__(self, urdf: Path) -> None:
        if absent := why_absent():
            raise ImportError(absent)
        from figaroh.tools.load_robot import load_robot

        self.robot = load_robot(str(urdf), load_by_urdf=True)
        self.joints = tuple(self.robot.model.names)[1:]

    def regressor(self, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
        """FIGAROH's regressor of given states, each (t, n); shape (n t, 14 n), all rows of joint 1 first."""
        from figaroh.tools.regressor import build_regressor_basic

        everything = dict.fromkeys(("has_friction", "has_actuator_inertia", "has_joint_offset"), True)
        chosen = everything | {"is_joint_torques": True, "act_idxv": list(range(len(self.joints)))}
        return build_regressor_basic(self.robot, position, velocity, acceleration, chosen)

    def identify(
        self, position: np.ndarray, torque: np.ndarray, rate: float, settings: Settings
    ) -> np.ndarray:
        """Relative residual (n,) of FIGAROH's whole identification of arrays (t, n), without its plots."""
        recording = self._recording(position, torque, rate, settings.edge)
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
            file = Path(folder) / "arm.yaml"
            file.write_text(json.dumps(_configuration(self.joints, rate, settings.cutoff)))  # JSON is YAML
            work = _subclass(lambda: recording)(self.robot, str(file))
            # FIGAROH leaves it to the user to name which model columns the joints are.
            every = list(range(len(self.joints)))
            work.identif_config |= {"act_idxq": every, "act_idxv": every}
            work.initialize()
            work.solve(
                decimate=settings.decimation > 1,
                decimation_factor=settings.decimation,
                plotting=False,
                wls=False,
            )
        return _relative_residual(work, len(self.joints))

    def _recording(self, position: np.ndarray, torque: np.ndarray, rate: float, edge: float) -> Any:
        from figaroh.data.trajectory import JOINT_TORQUE, TrajectoryData

        time = np.arange(len(position)) / rate
        inside = (time >= edge) & (time <= time[-1] - edge)
        return TrajectoryData(
            time, self.joints, position, torque, (JOINT_TORQUE,) * len(self.joints), "Nm", mask=inside
        )


def _subclass(load: Callable[[], Any]) -> Any:
    """The subclass that FIGAROH wants for each robot; it names where the data come from, and no more."""
    from figaroh.identification.base_identification import BaseIdentification

    class ArmIdentification(BaseIdentification):
        def load_trajectory_data(self, data_source: str | None = None) -> Any:
            return load()

    return ArmIdentification


def _configuration(joints: tuple[str, ...], rate: float, cutoff: float) -> dict[str, Any]:
    """FIGAROH's unified configuration; what is not given here stays at its default."""
    components = {"friction": True, "actuator_inertia": True, "joint_offset": True}
    unknown = [0.0] * len(joints)
    mechanics = {
        "friction_coefficients": {"viscous": unknown, "static": unknown},
        "actuator_inertias": unknown,
        "joint_offsets": unknown,
    }
    return {
        "robot": {
            "name": "arm",
            "properties": {"joints": {"active_joints": list(joints)}, "mechanics": mechanics},
        },
        "tasks": {
            "identification": {
                "problem": {"use_joint_torques": True, "model_components": components},
                "signal_processing": {"sampling_frequency": rate, "cutoff_frequency": cutoff},
            }
        },
    }


def _relative_residual(work: Any, joints: int) -> np.ndarray:
    """Norm of residual over norm of torque; rows are all those of joint 1, then of joint 2, and so on."""
    torque = work.tau_noised.reshape(joints, -1)
    residual = torque - work.tau_identif.reshape(joints, -1)
    return np.asarray(np.linalg.norm(residual, axis=1) / np.linalg.norm(torque, axis=1))


FRICTION_BLOCKS = 4
"""Columns a joint beyond its link's ten: viscous, Coulomb, rotor inertia, offset."""


def regressor_floor(
    kinematics: pin.Model, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> np.ndarray:
    """Regressor of rigid links, viscous and Coulomb friction, rotor inertia and offset, (t, n, 14 n).

    Nothing is checked and nothing is named: this is the time that any library pays which asks Pinocchio for
    one sample at a time and keeps what it gets.
    """
    samples, joints = position.shape
    rigid = 10 * joints
    out = np.zeros((samples, joints, rigid + FRICTION_BLOCKS * joints))
    data = kinematics.createData()
    for k in range(samples):
        out[k, :, :rigid] = pin.computeJointTorqueRegressor(
            kinematics, data, position[k], velocity[k], acceleration[k]
        )
    joint = np.arange(joints)
    for block, column in enumerate((velocity, np.sign(velocity), acceleration, 1.0)):
        out[:, joint, rigid + block * joints + joint] = column
    return out
