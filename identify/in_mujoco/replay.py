"""Replay: what a recording commanded, given to the arm in MuJoCo, from any of its moments on."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import RecordingError, RobotError
from ..export.mjcf_gears import TWIST
from ..model import Model
from ..preparation.prepare import Filtering, prepare
from ..recordings.recording import Recording
from ..recordings.recording_checks import check
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_drives import servos
from ..robot_files.mjcf_names import enum_of, joint_name
from .attached import Attached
from .callbacks import PURPOSE, optional

POSITION, TORQUE = "position", "torque"
"""What is commanded: positions, which the file's servos follow; or the torque that was measured."""


class Run(NamedTuple):
    """A recording as it is replayed; n joints.

    Attributes:
        name: Of the recording.
        time: Shape (t,) [s].
        position: Shape (t, n) [rad].
        velocity: Shape (t, n) [rad/s].
        effort: Current, or torque of the joint, shape (t, n) [A, N m].
        current: Whether it is current.
        command: Position that was commanded, shape (t, n) [rad]; None if it was not recorded.
        noise: What the encoder adds, shape (n,) [rad].
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
        """Its motion behind the filters of fits; what was commanded and its effort as they were.

        Raises:
            RecordingError: It is too short, or has no effort.
        """
        ready = prepare(check(recording), filtering)
        time, command = ready.motion.time, recording.signals.get("command")
        sent = None
        if command is not None:
            sent = _between(time, command.time, command.values)
        return cls(
            recording.name, time, ready.motion.position, ready.motion.velocity, ready.current,
            ready.measures == "current", sent, ready.encoder_noise,
        )  # fmt: skip

    def torque(self, arm: Model) -> np.ndarray:
        """Torque of the joints that its effort is on an arm, shape (t, n) [N m]."""
        if not self.current:
            return self.effort
        return self.effort * arm.robot.drive_gain @ arm.robot.coupling


def what_is_commanded(model: Any, runs: Sequence[Run], joints: Sequence[str], asked: str = "") -> str:
    """`POSITION` where all runs have commands and all joints servos that follow them, else `TORQUE`.

    Raises:
        RecordingError: Positions are asked for, and a run has none.
        RobotError: Or the file has no servos.
    """
    lacking = [run.name for run in runs if run.command is None]
    followed = bool(servos(model, joints))
    if asked == POSITION and lacking:
        raise RecordingError(f"{lacking[0]} has no commanded positions; --commands torque takes its effort")
    if asked == POSITION and not followed:
        raise RobotError("the file has no position servo for every joint; --commands torque takes the effort")
    return asked or (POSITION if followed and not lacking else TORQUE)


class Simulator:
    """The arm in MuJoCo, commanded as recordings were.

    Args:
        text: Of the MJCF.
        folder: In which its files lie.
        arm: Its joints, and the drive gains by which current is torque.
        commands: `POSITION` or `TORQUE`.
        attach: Whether what MJCF lacks of the arm acts too.
    """

    def __init__(self, text: str, folder: str, arm: Model, commands: str, attach: bool) -> None:
        self._mujoco = optional("mujoco", PURPOSE, "mujoco")
        self.model, self._arm, self._commands = compile_mjcf(text, folder), arm, commands
        self.model.opt.disableflags |= enum_of("mjtDisableBit", "mjDSBL_AUTORESET")
        self._data = self._mujoco.MjData(self.model)
        joints = [self.model.joint(name) for name in arm.robot.joints]
        self._places = [int(joint.qposadr[0]) for joint in joints]
        self._dofs = [int(joint.dofadr[0]) for joint in joints]
        self._twists = self._twists_of(arm.robot.joints)
        self._servos = servos(self.model, arm.robot.joints) if commands == POSITION else []
        if commands == TORQUE:
            self._silence([int(joint.id) for joint in joints])
        self._attached = Attached(self.model, self._data, arm) if attach else None

    def _twists_of(self, joints: Sequence[str]) -> list[tuple[int, int]]:
        """Joints with a gear that gives way, by their place among all, and the numbers of their twists."""
        names = [joint_name(self.model, joint) for joint in range(self.model.njnt)]
        twists = [TWIST.format(joint) for joint in joints]
        return [(place, names.index(name)) for place, name in enumerate(twists) if name in names]

    def _silence(self, joints: Sequence[int]) -> None:
        """Take the file's actuators off these joints: what was measured acts in their place."""
        kind = enum_of("mjtTrn", "mjTRN_JOINT")
        for actuator in range(self.model.nu):
            if (
                self.model.actuator_trntype[actuator] == kind
                and self.model.actuator_trnid[actuator][0] in joints
            ):
                self.model.actuator_gainprm[actuator] = self.model.actuator_biasprm[actuator] = 0.0

    def __enter__(self) -> "Simulator":
        return self

    def __exit__(self, *_: object) -> None:
        if self._attached is not None:
            self._attached.detach()

    def roll(self, run: Run, first: int, last: int) -> np.ndarray:
        """Positions at samples first + 1 to last of a run, from where it was at `first`, shape (k, n) [rad].

        Infinite from where the simulation has diverged.
        """
        mujoco, model, data = self._mujoco, self.model, self._data
        mujoco.mj_resetData(model, data)
        data.qpos[self._places], data.qvel[self._dofs] = run.position[first], run.velocity[first]
        if self._twists:
            self._bend(run, first)
        step, wanted = model.opt.timestep, run.time[first + 1 : last + 1] - run.time[first]
        time = step * np.arange(int(np.ceil(wanted[-1] / step)) + 1)
        commands = self._along(run, run.time[first] + time[:-1], step)
        seen = np.full((len(time), len(self._places)), np.inf)
        seen[0] = run.position[first]
        for row, command in enumerate(commands):
            if self._servos:
                data.ctrl[self._servos] = command
            else:
                data.qfrc_applied[self._dofs] = command
            mujoco.mj_step(model, data)
            position = data.qpos[self._places]
            if not np.all(np.abs(position) < BEYOND):
                break
            seen[row + 1] = position
        with np.errstate(invalid="ignore"):
            return np.nan_to_num(_between(wanted, time, seen), nan=np.inf)

    def _bend(self, run: Run, row: int) -> None:
        """Twist gears by what they carry at a sample of a run, as if they did not swing."""
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

    def _along(self, run: Run, time: np.ndarray, step: float) -> np.ndarray:
        """What is commanded in each step, on lines between samples: controllers interpolate; shape (k, n)."""
        if self._servos:
            assert run.command is not None
            return self.model.actuator_gear[self._servos, 0] * _between(time, run.time, run.command)
        return _between(time + 0.5 * step, run.time, run.torque(self._arm))  # in the middle of the step


def _between(time: np.ndarray, known: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (t, n) at other times (k,), on lines between them, shape (k, n)."""
    return np.stack([np.interp(time, known, column) for column in values.T], axis=1)


BEYOND = 1e3
"""Position at which a simulation counts as diverged [rad, m]: a hundred turns and more."""
