"""A trivial rival for logs of position servos: one stiffness and one delay of all servos, friction by joint.

It only simulates: from recorded states, for 0.5 and 2 s, with commands that are held between samples. Numbers
are searched by coordinate steps; damping and dry friction of each joint by the error of that joint.
"""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from exidyn.identification.in_mujoco.replay import Run

HORIZONS = (0.5, 2.0)
"""Times after a start up to which positions are compared [s]."""
EVERY = 4.0
"""Time between starts [s]."""
FIRST = {"kp": 10.0, "delay": 0.0, "damping": 0.6, "friction": 0.05}
"""Numbers with which the search starts."""
STIFFNESSES = (3.0, 30.0, 100.0)
"""Further stiffnesses with which it may start [N m/rad]."""
STEPS = (
    {"kp": (0.6, 1.5), "delay": (-0.02, 0.02), "damping": (0.6, 1.5), "friction": (2.0, 5.0)},
    {"kp": (0.8, 1.25), "delay": (-0.01, 0.01), "damping": (0.8, 1.25), "friction": (0.7, 1.5)},
    {"kp": (0.9, 1.1), "delay": (-0.005, 0.005), "damping": (0.9, 1.1), "friction": (0.8, 1.25)},
)
"""Factors on numbers, and shifts of the delay [s]."""


class Rival:
    """The numbers of the servos of a file, fitted to runs.

    Args:
        text: Text of the file.
        joints: Joints of the runs.
        runs: Runs with commands.
    """

    def __init__(self, text: str, joints: Sequence[str], runs: Sequence[Run]) -> None:
        self._spec, self._joints, self._runs = mujoco.MjSpec.from_string(text), joints, runs
        self.model = self._spec.compile()
        ids = [self.model.joint(name).id for name in joints]
        self._qpos, self._dofs = self.model.jnt_qposadr[ids], self.model.jnt_dofadr[ids]
        self._servos = [int(np.flatnonzero(self.model.actuator_trnid[:, 0] == joint)[0]) for joint in ids]

    def text(self) -> str:
        """The file with the fitted numbers."""
        values = self._searched()
        for place, (name, servo) in enumerate(zip(self._joints, self._servos, strict=True)):
            joint, actuator = self._spec.joint(name), self._spec.actuators[servo]
            joint.damping[0], joint.frictionloss = values["damping"][place], values["friction"][place]
            actuator.gainprm[0], actuator.biasprm[1:3] = values["kp"], [-values["kp"], 0.0]
            if values["delay"]:
                actuator.delay = values["delay"]
                actuator.nsample = int(np.ceil(values["delay"] / self.model.opt.timestep)) + 1
        self._spec.compile()
        return str(self._spec.to_xml())

    def _searched(self) -> dict[str, Any]:
        count = len(self._joints)
        values: dict[str, Any] = {
            name: first if name in ("kp", "delay") else np.full(count, first) for name, first in FIRST.items()
        }
        best = self._errors(values)
        for stiffness in STIFFNESSES:
            values, best = self._moved(values, best, "kp", stiffness)
        for steps in STEPS:
            for name, moves in steps.items():
                base = values[name]
                for move in moves:
                    new = max(0.0, base + move) if name == "delay" else base * move
                    values, best = self._moved(values, best, name, new)
                best = self._errors(values)
        return values

    def _moved(
        self, values: dict[str, Any], best: np.ndarray, name: str, new: Any
    ) -> tuple[dict[str, Any], np.ndarray]:
        """The numbers with a new one where errors decrease: of all joints together, or of each by itself."""
        errors = self._errors(values | {name: new})
        if name in ("kp", "delay"):
            return (values | {name: new}, errors) if np.mean(np.log(errors / best)) < 0.0 else (values, best)
        better = errors < best
        return values | {name: np.where(better, new, values[name])}, np.where(better, errors, best)

    def _errors(self, values: dict[str, Any]) -> np.ndarray:
        """Mean squared error of each joint over starts and horizons, shape (n,) [rad^2]."""
        model = self.model
        model.actuator_gainprm[self._servos, 0] = values["kp"]
        model.actuator_biasprm[self._servos, 1:3] = [-values["kp"], 0.0]
        model.dof_damping[self._dofs], model.dof_frictionloss[self._dofs] = values["damping"], values["friction"]
        squares = []
        for run in self._runs:
            starts = np.arange(run.time[0] + 1.0, run.time[-1] - HORIZONS[-1], EVERY)
            squares += [self._from(run, start, values["delay"]) for start in starts.tolist()]
        return np.asarray(np.mean(squares, axis=0))

    def _from(self, run: Run, start: float, delay: float) -> np.ndarray:
        """Squared errors after a start, averaged over both horizons, shape (n,) [rad^2]."""
        model, data = self.model, mujoco.MjData(self.model)
        times = start + model.opt.timestep * np.arange(1, round(HORIZONS[-1] / model.opt.timestep) + 1)
        real, state = _at(run.time, run.position, times), (run.position, run.velocity)
        data.qpos[self._qpos], data.qvel[self._dofs] = (
            _at(run.time, values, np.array([start]))[0] for values in state
        )
        assert run.command is not None
        rows = np.searchsorted(run.time, times - model.opt.timestep - delay + 1e-9, side="right") - 1
        simulated = np.empty_like(real)
        for step, row in enumerate(np.maximum(rows, 0)):
            data.ctrl[self._servos] = run.command[row]
            mujoco.mj_step(model, data)
            simulated[step] = data.qpos[self._qpos]
        squares = (simulated - real) ** 2
        counts = [round(horizon / model.opt.timestep) for horizon in HORIZONS]
        return np.asarray(np.mean([np.mean(squares[:count], axis=0) for count in counts], axis=0))


def _at(time: np.ndarray, values: np.ndarray, moments: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(moments, time, column) for column in values.T], axis=1)
