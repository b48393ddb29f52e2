"""Replay: the commands of a recording, applied to the arm in MuJoCo from any sample onward."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import RecordingError, RobotError
from ..export.mjcf_gears import TWIST
from ..model import Model
from ..preparation.prepare import Filtering, prepare
from ..preparation.undelayed import without_delay
from ..recordings.recording import Recording
from ..recordings.recording_checks import check
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_drives import servos
from ..robot_files.mjcf_names import enum_of, input_of, joint_name
from .attached import Attached
from .callbacks import PURPOSE, optional
from .motors import silence

POSITION, TORQUE = "position", "torque"
"""What is commanded: positions, which the servos of the file follow, or the measured torque."""


class Run(NamedTuple):
    """A recording, prepared for replay; n joints.

    Attributes:
        name: Name of the recording.
        time: Time, shape (t,) [s].
        position: Position, shape (t, n) [rad].
        velocity: Velocity, shape (t, n) [rad/s].
        effort: Motor current or joint torque, shape (t, n) [A, N m].
        current: Whether the effort is current.
        command: Commanded position, shape (t, n) [rad]; None if it was not recorded.
        noise: Encoder noise, shape (n,) [rad].
    """

    name: str
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    effort: np.ndarray
    current: bool
    command: np.ndarray | None
    noise: np.ndarray

    @classmethod
    def of(cls, recording: Recording, filtering: Filtering) -> "Run":
        """The run of a recording: its filtered motion, and its commands and effort at the times they acted.

        Raises:
            RecordingError: If the recording is too short or has no effort.
        """
        checked = check(recording)
        prepared = prepare(checked, filtering)
        # The time at which the servos received the commands, where the model states a delay of the recorder.
        time, command = prepared.motion.time, without_delay(checked).signals.get("command")
        commanded = None
        if command is not None:
            commanded = _between(time, command.time, command.values)
        return cls(
            recording.name, time, prepared.motion.position, prepared.motion.velocity, prepared.current,
            prepared.measures == "current", commanded, prepared.encoder_noise,
        )  # fmt: skip

    def torque(self, arm: Model) -> np.ndarray:
        """Joint torque of the recorded effort on an arm, shape (t, n) [N m]."""
        if not self.current:
            return self.effort
        return self.effort * arm.robot.drive_gain @ arm.robot.coupling


def what_is_commanded(model: Any, runs: Sequence[Run], joints: Sequence[str], requested: str = "") -> str:
    """The requested kind of command; by default `POSITION` if runs and file support it, else `TORQUE`.

    Positions need commands in all runs and position servos for all joints.

    Raises:
        RecordingError: If positions are requested and a run has no commanded positions.
        RobotError: If positions are requested and the file has no servos.
    """
    without_commands = [run.name for run in runs if run.command is None]
    has_servos = bool(servos(model, joints))
    if requested == POSITION and without_commands:
        raise RecordingError(
            f"{without_commands[0]} has no commanded positions; replay its effort with --commands torque"
        )
    if requested == POSITION and not has_servos:
        raise RobotError(
            "the file lacks position servos for some joints; replay the effort with --commands torque"
        )
    return requested or (POSITION if has_servos and not without_commands else TORQUE)


class Simulator:
    """The arm in MuJoCo, with the commands of recordings.

    Args:
        text: Text of the MJCF.
        folder: Folder of the files that it refers to.
        arm: The arm, with the drive gains that convert current to torque.
        commands: `POSITION` or `TORQUE`.
        attach: Whether to attach the effects that MJCF cannot express.
    """

    def __init__(self, text: str, folder: str, arm: Model, commands: str, attach: bool) -> None:
        self._mujoco = optional("mujoco", PURPOSE, "mujoco")
        self.model, self._arm, self._commands = compile_mjcf(text, folder), arm, commands
        self.model.opt.disableflags |= enum_of("mjtDisableBit", "mjDSBL_AUTORESET")
        self._data = self._mujoco.MjData(self.model)
        joints = [self.model.joint(name) for name in arm.robot.joints]
        self._qpos = [int(joint.qposadr[0]) for joint in joints]
        self._dofs = [int(joint.dofadr[0]) for joint in joints]
        self._twists = self._twists_of(arm.robot.joints)
        self._servos = servos(self.model, arm.robot.joints) if commands == POSITION else []
        self._inputs = [input_of(self.model, servo) for servo in self._servos]
        if commands == TORQUE:
            silence(self.model, [int(joint.id) for joint in joints])
        self._attached = Attached(self.model, self._data, arm) if attach else None

    def _twists_of(self, joints: Sequence[str]) -> list[tuple[int, int]]:
        """Index of each joint with an elastic gear, and MuJoCo's index of the joint for its twist."""
        names = [joint_name(self.model, joint) for joint in range(self.model.njnt)]
        twists = [TWIST.format(joint) for joint in joints]
        return [(index, names.index(name)) for index, name in enumerate(twists) if name in names]

    def __enter__(self) -> "Simulator":
        return self

    def __exit__(self, *_: object) -> None:
        if self._attached is not None:
            self._attached.detach()

    def roll(self, run: Run, first: int, last: int) -> np.ndarray:
        """Simulated positions at samples first + 1 to last of a run, shape (k, n) [rad].

        The simulation starts in the state at sample `first`; positions are infinite once it has diverged.
        """
        mujoco, model, data = self._mujoco, self.model, self._data
        mujoco.mj_resetData(model, data)
        data.qpos[self._qpos], data.qvel[self._dofs] = run.position[first], run.velocity[first]
        if self._twists:
            self._bend(run, first)
        step, sample_time = model.opt.timestep, run.time[first + 1 : last + 1] - run.time[first]
        time = step * np.arange(int(np.ceil(sample_time[-1] / step)) + 1)
        commands = self._commands_in_steps(run, run.time[first] + time[:-1], step)
        positions = np.full((len(time), len(self._qpos)), np.inf)
        positions[0] = run.position[first]
        for row, command in enumerate(commands):
            if self._servos:
                data.ctrl[self._inputs] = command
            else:
                data.qfrc_applied[self._dofs] = command
            mujoco.mj_step(model, data)
            position = data.qpos[self._qpos]
            if not np.all(np.abs(position) < BEYOND):
                break
            positions[row + 1] = position
        with np.errstate(invalid="ignore"):
            return np.nan_to_num(_between(sample_time, time, positions), nan=np.inf)

    def _bend(self, run: Run, row: int) -> None:
        """Set the twist of the gears to its static value under their load at a sample of a run."""
        model, data = self.model, self._data
        rows = slice(max(row - 1, 0), row + 2)
        data.qacc[:] = 0.0
        data.qacc[self._dofs] = np.gradient(run.velocity[rows], run.time[rows], axis=0)[min(row, 1)]
        self._mujoco.mj_inverse(model, data)
        for _, twist in self._twists:
            place, dof = int(model.jnt_qposadr[twist]), int(model.jnt_dofadr[twist])
            load, stiffness = data.qfrc_inverse[dof], model.jnt_stiffness[twist]
            half = model.jnt_range[twist][1] if model.jnt_limited[twist] else 0.0
            data.qpos[place] = -load / stiffness if stiffness else -half * np.sign(load)
        data.qacc[:] = 0.0

    def _commands_in_steps(self, run: Run, time: np.ndarray, step: float) -> np.ndarray:
        """Command in each step, linear between samples because controllers interpolate, shape (k, n)."""
        if self._servos:
            assert run.command is not None
            return self.model.actuator_gear[self._servos, 0] * _between(time, run.time, run.command)
        return _between(time + 0.5 * step, run.time, run.torque(self._arm))  # in the middle of the step


def _between(time: np.ndarray, known: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (t, n) interpolated linearly at other times (k,), shape (k, n)."""
    return np.stack([np.interp(time, known, column) for column in values.T], axis=1)


BEYOND = 1e3
"""Position beyond which a simulation counts as diverged [rad, m]: more than a hundred turns."""
