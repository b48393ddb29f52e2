"""Replay: the commands of a recording, applied to the arm in MuJoCo from any sample onward."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from ..errors import RecordingError, RobotError
from ..export.mjcf_gears import TWIST
from ..model import Model
from ..preparation.filters import without_delay
from ..preparation.prepare import Filtering, prepare
from ..recordings.recording import Recording, interpolated
from ..recordings.recording_checks import check
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_drives import servos
from ..robot_files.mjcf_elements import enum_of, input_of, joint_names
from .attached import Attached
from .callbacks import PURPOSE, optional
from .switched_off import hold_others, mount, silence

POSITION, TORQUE = "position", "torque"
"""What is commanded: positions, which the servos of the file follow, or the measured torque."""


class Run(NamedTuple):
    """A recording, prepared for replay; n joints."""

    name: str  # name of the recording
    time: np.ndarray  # time, shape (t,) [s]
    position: np.ndarray  # position, shape (t, n) [rad]
    velocity: np.ndarray  # velocity, shape (t, n) [rad/s]
    effort: np.ndarray  # motor current or joint torque, shape (t, n) [A, N m]
    current: bool  # whether the effort is current
    command: np.ndarray | None  # commanded position, shape (t, n) [rad]; None if it was not recorded
    noise: np.ndarray  # encoder noise, shape (n,) [rad]

    @classmethod
    def of(cls, recording: Recording, filtering: Filtering) -> "Run":
        """Run of a recording: its filtered motion, and its commands and effort at the times they acted."""
        checked = check(recording)
        prepared = prepare(checked, filtering)
        # The time at which the servos received the commands, where the model states a delay of the recorder.
        time, command = prepared.motion.time, without_delay(checked).signals.get("command")
        commanded = None if command is None else command.at(time)
        return cls(
            recording.name, time, prepared.motion.position, prepared.motion.velocity, prepared.current,
            prepared.measures == "current", commanded, prepared.encoder_noise,
        )  # fmt: skip

    def torque(self, arm: Model) -> np.ndarray:
        """Joint torque of the recorded effort on an arm, shape (t, n) [N m]."""
        if not self.current:
            return self.effort
        return self.effort * arm.robot.drive_gain @ arm.robot.coupling


def what_is_commanded(
    model: Any, runs: Sequence[Recording], joints: Sequence[str], requested: str = ""
) -> str:
    """The requested kind of command; by default `POSITION` if runs and file support it, else `TORQUE`.

    Positions need commands in all runs and position servos for all joints.
    """
    without_commands = [run.name for run in runs if "command" not in run.signals]
    has_servos = bool(servos(model, joints))
    if requested == POSITION and without_commands:
        raise RecordingError(
            f"{without_commands[0]} has no commanded positions; replay its effort with --commands torque"
        )
    if requested == POSITION and not has_servos:
        raise RobotError(
            "the file lacks position servos for some joints; state the gains of the controller "
            "(--kp KP --kd KD), or replay the effort with --commands torque"
        )
    return requested or (POSITION if has_servos and not without_commands else TORQUE)


class Simulator:
    """The arm in MuJoCo, by the text of an MJCF, with commands of recordings: `POSITION` or `TORQUE`.

    The drive gains of the arm convert current to torque. With `attach`, the effects act that MJCF cannot
    express. With `held`, commands are held from sample to sample rather than interpolated. `original` is the
    gravity of the original file, see `switched_off.weight`; a text with another one keeps it.
    """

    def __init__(
        self,
        text: str,
        folder: str,
        arm: Model,
        commands: str,
        attach: bool,
        held: bool = False,
        original: np.ndarray | None = None,
    ) -> None:
        self._mujoco = optional("mujoco", PURPOSE, "mujoco")
        self.model, self._arm, self._commands = compile_mjcf(text, folder), arm, commands
        self.model.opt.disableflags |= enum_of("mjtDisableBit", "mjDSBL_AUTORESET")
        self._others = hold_others(self.model, arm.robot, "MJCF")
        mount(self.model, arm.robot.gravity, original)
        self._data = self._mujoco.MjData(self.model)
        joints = [self.model.joint(name) for name in arm.robot.joints]
        self._qpos = [int(joint.qposadr[0]) for joint in joints]
        self._dofs = [int(joint.dofadr[0]) for joint in joints]
        # MuJoCo's indices of the joints for the twists of elastic gears.
        names = joint_names(self.model)
        twists = [TWIST.format(joint) for joint in arm.robot.joints]
        self._twists = [names.index(twist) for twist in twists if twist in names]
        self._servos = servos(self.model, arm.robot.joints) if commands == POSITION else []
        self._inputs = [input_of(self.model, servo) for servo in self._servos] or self._dofs
        self._held, self.delay = held, self._take_delays()
        if commands == TORQUE:
            silence(self.model, [int(joint.id) for joint in joints])
        self._attached = Attached(self.model, self._data, arm) if attach else None

    def _take_delays(self) -> np.ndarray:
        """Delays of the servos (n,) [s], which are applied to the commands of the recording instead.

        MuJoCo's history of commands is empty at a start; the recording has the commands before it.
        """
        if not self._servos or not hasattr(self.model, "actuator_delay"):
            return np.zeros(len(self._servos))
        delay = np.array(self.model.actuator_delay[self._servos])
        self.model.actuator_delay[self._servos] = 0.0
        return delay

    def __enter__(self) -> "Simulator":
        return self

    def __exit__(self, *_: object) -> None:
        if self._attached is not None:
            self._attached.detach()

    def roll(self, windows: Sequence[tuple[Run, int, int]]) -> list[np.ndarray]:
        """Simulated positions at samples first + 1 to last of windows (run, first, last), (k, n) each [rad].

        A simulation starts in the state at sample `first`; positions are infinite once it has diverged.
        """
        step = self.model.opt.timestep
        times = [
            step * np.arange(int(np.ceil((run.time[last] - run.time[first]) / step)) + 1)
            for run, first, last in windows
        ]
        inputs = [
            self.inputs_at(run, run.time[first] + time[:-1], self.delay, self._held)
            for (run, first, _), time in zip(windows, times, strict=True)
        ]
        states = np.array([self.state_at(run, first) for run, first, _ in windows])
        if self._attached is None:
            steps = max(map(len, inputs))
            padded = [np.pad(rows, ((0, steps - len(rows)), (0, 0)), "edge") for rows in inputs]
            positions = [*self.rolled([self.model] * len(windows), states, np.array(padded))]
        else:
            positions = [self._stepped(*pair) for pair in zip(states, inputs, strict=True)]
        simulated = []
        for (run, first, last), time, moved in zip(windows, times, positions, strict=True):
            moved[np.logical_or.accumulate(~np.all(np.abs(moved) < BEYOND, axis=1))] = np.inf
            every = np.vstack([run.position[first], moved])[: len(time)]
            with np.errstate(invalid="ignore"):
                moments = run.time[first + 1 : last + 1] - run.time[first]
                simulated.append(np.nan_to_num(interpolated(moments, time, every), nan=np.inf))
        return simulated

    def _stepped(self, state: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """Positions after each step with effects attached, from a state, with inputs (k, n), shape (k, n)."""
        model, data = self.model, self._data
        positions = np.full(inputs.shape, np.inf)
        self._mujoco.mj_resetData(model, data)
        self._mujoco.mj_setState(model, data, state, enum_of("mjtState", "mjSTATE_FULLPHYSICS"))
        target = data.ctrl if self._servos else data.qfrc_applied
        for row, command in enumerate(inputs):
            target[self._inputs] = command
            self._mujoco.mj_step(model, data)
            positions[row] = data.qpos[self._qpos]
            if not np.all(np.abs(positions[row]) < BEYOND):
                break
        return positions

    def rolled(self, models: Sequence[Any], states: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """Positions after each step of r versions of the model, shape (r, k, n).

        Each starts in a state by `state_at`, and has inputs (r, k, n) in all steps.
        """
        control = np.zeros((*inputs.shape[:2], self.model.nu if self._servos else self.model.nv))
        control[:, :, self._inputs] = inputs
        kind = enum_of("mjtState", "mjSTATE_CTRL" if self._servos else "mjSTATE_QFRC_APPLIED")
        data = [self._mujoco.MjData(self.model) for _ in range(os.cpu_count() or 1)]
        rollout = optional("mujoco.rollout", PURPOSE, "mujoco").rollout
        with _quiet(self._mujoco):
            moved, _ = rollout(list(models), data, states, control, control_spec=int(kind))
        return np.asarray(moved[:, :, 1 + np.array(self._qpos)])  # time is first

    def _bend(self, run: Run, row: int) -> None:
        """Set the twist of the gears to its static value under their load at a sample of a run."""
        model, data = self.model, self._data
        rows = slice(max(row - 1, 0), row + 2)
        data.qacc[:] = 0.0
        data.qacc[self._dofs] = np.gradient(run.velocity[rows], run.time[rows], axis=0)[min(row, 1)]
        self._mujoco.mj_inverse(model, data)
        for twist in self._twists:
            place, dof = int(model.jnt_qposadr[twist]), int(model.jnt_dofadr[twist])
            load, stiffness = data.qfrc_inverse[dof], model.jnt_stiffness[twist]
            half = model.jnt_range[twist][1] if model.jnt_limited[twist] else 0.0
            data.qpos[place] = -load / stiffness if stiffness else -half * np.sign(load)
        data.qacc[:] = 0.0

    def state_at(self, run: Run, first: int) -> np.ndarray:
        """Full state of MuJoCo at a sample of a run."""
        model, data = self.model, self._data
        self._mujoco.mj_resetData(model, data)
        data.qpos[self._qpos], data.qvel[self._dofs] = run.position[first], run.velocity[first]
        self._others.place(model, data)
        if self._twists:
            self._bend(run, first)
        kind = enum_of("mjtState", "mjSTATE_FULLPHYSICS")
        state = np.empty(self._mujoco.mj_stateSize(model, kind))
        self._mujoco.mj_getState(model, data, state, kind)
        return state

    def inputs_at(self, run: Run, time: np.ndarray, delay: np.ndarray, held: bool) -> np.ndarray:
        """Inputs at times (k,) [s], shape (k, n), as controllers hold or interpolate commands.

        They are positions with a delay of each servo (n,) [s], or joint torques in the middle of each step.
        """
        if not self._servos:
            return interpolated(time + 0.5 * self.model.opt.timestep, run.time, run.torque(self._arm))
        assert run.command is not None
        gear, times = self.model.actuator_gear[self._servos, 0], time[:, None] - delay
        if held:
            places = np.searchsorted(run.time, times + TOUCHING, side="right") - 1
            return gear * np.take_along_axis(run.command, np.maximum(places, 0), axis=0)
        return gear * interpolated(times, run.time, run.command)


@contextmanager
def _quiet(mujoco: Any) -> Iterator[None]:
    """No warnings of MuJoCo, on the terminal and in a file: some versions that are tried diverge."""
    handler = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(handler)


TOUCHING = 1e-9
"""Time by which a step may begin before the sample whose command it takes, due to rounding [s]."""
BEYOND = 1e3
"""Position beyond which a simulation counts as diverged [rad, m]: more than a hundred turns."""
