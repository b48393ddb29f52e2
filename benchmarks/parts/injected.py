"""Real runs as background, and effects by formulas that differ from exidyn's own."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from scipy import signal

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording, Signal

from .diagnose_real.sets import Runs

SMOOTH = 8.0
"""Cut-off of positions before they are differentiated [Hz]: motion is slower."""
COARSE = 25.0
"""Rows a second of the least squares that gives loads and visibility."""
STILL = 0.02
"""Share of the usual speed below which a joint's rows do not count."""


@dataclass(frozen=True, eq=False)
class Background:
    """The runs of one set."""

    model: Model  # Nominal model of the set
    runs: Runs  # Role and recording

    @cached_property
    def motions(self) -> list[Motion]:
        """Motion of each run at the time stamps of its positions."""
        return [_motion(run) for _, run in self.runs]

    @cached_property
    def torques(self) -> list[np.ndarray]:
        """Measured joint torque of each run at the same time stamps, (t, n) [N m]."""
        return [
            _at(run.signals[effort(run)], motion.time) * self.per_unit(run)
            for (_, run), motion in zip(self.runs, self.motions, strict=True)
        ]

    def per_unit(self, run: Recording) -> np.ndarray:
        """Torque per unit of what was measured, shape (n,); one where a gain is not stated."""
        gain = np.asarray(self.model.robot.drive_gain, float)
        stated = effort(run) == "current" and np.all(np.isfinite(gain)) and np.all(gain != 0.0)
        return gain if stated else np.ones(self.model.robot.dof)

    @cached_property
    def fit(self) -> tuple[np.ndarray, list[np.ndarray]]:
        """Least-squares values of the nominal model's columns, and its regressor of each run, coarse."""
        columns = [self.model.regressor(motion[:: self._step(motion)]) for motion in self.motions]
        left, right = [], []
        for regressor, torque, motion in zip(columns, self.torques, self.motions, strict=True):
            weight = self._moves(motion)
            left.append((regressor * weight[:, :, None]).reshape(-1, regressor.shape[2]))
            right.append((_coarse(torque, motion, self._step(motion)) * weight).ravel())
        values = np.linalg.lstsq(np.concatenate(left), np.concatenate(right), rcond=1e-8)[0]
        return values, columns

    @cached_property
    def loads(self) -> list[np.ndarray]:
        """Torque that the gears transmit, (t, n) [N m]."""
        gears = replace(self.model, effects=tuple(e for e in self.model.effects if e.transmitted))
        own = [c for e, c in zip(self.model.effects, self.model.columns, strict=True) if e.transmitted]
        values = np.concatenate([self.fit[0][c] for c in own])
        return [gears.regressor(motion) @ values for motion in self.motions]

    @cached_property
    def residual(self) -> np.ndarray:
        """Root mean square of what the least squares leave on each joint, shape (n,) [N m]."""
        return self._rms([self._left(torque, place) for place, torque in enumerate(self.torques)])

    def visible(self, added: list[np.ndarray]) -> float:
        """Torque (t, n) of each run that no values of the nominal model explain, over the residual [-]."""
        flat = [
            (regressor * (self._moves(motion) / self.residual)[:, :, None]).reshape(-1, regressor.shape[2])
            for regressor, motion in zip(self.fit[1], self.motions, strict=True)
        ]
        coarse = [
            _coarse(torque, motion, self._step(motion)) * self._moves(motion) / self.residual
            for torque, motion in zip(added, self.motions, strict=True)
        ]
        matrix, vector = np.concatenate(flat), np.concatenate([one.ravel() for one in coarse])
        left = vector - matrix @ np.linalg.lstsq(matrix, vector, rcond=1e-8)[0]
        by_joint = left.reshape(-1, self.model.robot.dof)
        return float(np.sqrt(np.mean(by_joint**2, axis=0)).max())

    def _left(self, torque: np.ndarray, place: int) -> np.ndarray:
        values, columns = self.fit
        motion = self.motions[place]
        left = _coarse(torque, motion, self._step(motion)) - columns[place] @ values
        return left * self._moves(motion)

    def _rms(self, rows: list[np.ndarray]) -> np.ndarray:
        weights = np.concatenate([self._moves(motion) for motion in self.motions])
        return np.sqrt(np.sum(np.concatenate(rows) ** 2, axis=0) / np.maximum(weights.sum(axis=0), 1.0))

    def _step(self, motion: Motion) -> int:
        return max(int(_rate(motion.time) / COARSE), 1)

    def _moves(self, motion: Motion) -> np.ndarray:
        usual = np.sqrt(np.mean(motion.velocity**2, axis=0))
        return (np.abs(motion.velocity[:: self._step(motion)]) > STILL * usual).astype(float)


def effort(run: Recording) -> str:
    """Which signal of a run stands for its torque."""
    return "current" if "current" in run.signals else "torque"


def _rate(time: np.ndarray) -> float:
    return 1.0 / float(np.median(np.diff(time)))


def _at(one: Signal, time: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(time, one.time, column) for column in one.values.T], axis=1)


def _coarse(torque: np.ndarray, motion: Motion, step: int) -> np.ndarray:
    """Low-passed and thinned."""
    rate = _rate(motion.time)
    sections = signal.butter(4, min(0.4 * rate / step, 0.45 * rate), fs=rate, output="sos")
    return signal.sosfiltfilt(sections, torque, axis=0)[::step]


def _motion(run: Recording) -> Motion:
    position = run.signals["position"]
    rate = _rate(position.time)
    sections = signal.butter(4, min(SMOOTH, 0.4 * rate), fs=rate, output="sos")
    smooth = signal.sosfiltfilt(sections, position.values, axis=0)
    velocity = np.gradient(smooth, position.time, axis=0)
    acceleration = np.gradient(velocity, position.time, axis=0)
    payload = run.payload.name if run.payload else ""
    return Motion.of(position.time, smooth, velocity, acceleration, payload=payload)


Torques = list[np.ndarray]
"""One array (t, n) a run [N m]."""


class Added(NamedTuple):
    """An effect's torque in every run, of unit size; None where it cannot be on this joint."""

    torques: Torques  # Of each run, (t, n), as torque that the motor has to give
    joints: tuple[int, ...]  # Where it is, from 0; empty where it belongs to the whole arm
    sized: bool = False  # Whether it has the size that it has
    most: float = 0.5  # Root mean square over that of the joint's torque, at most [-]
    largest: float = np.inf  # Multiple of the unit size that physics allows


Effect = Callable[[Background, int, np.random.Generator], Added | None]


def _one(background: Background, joint: int, values: list[np.ndarray]) -> Added:
    torques = [np.zeros_like(motion.position) for motion in background.motions]
    for torque, value in zip(torques, values, strict=True):
        torque[:, joint] = value
    return Added(torques, (joint,))


def _usual(background: Background, joint: int) -> float:
    """Usual speed of a joint [rad/s]."""
    return float(np.sqrt(np.mean(np.concatenate([m.velocity[:, joint] ** 2 for m in background.motions]))))


def _sign(speed: np.ndarray, usual: float) -> np.ndarray:
    """How dry friction turns over: steeply, and not by the formula of the fit."""
    return speed / np.hypot(speed, 0.01 * usual)


def load_dependent_friction(background: Background, joint: int, rng: np.random.Generator) -> Added:
    usual = _usual(background, joint)
    return _one(background, joint, [
        _sign(motion.velocity[:, joint], usual) * np.abs(load[:, joint])
        for motion, load in zip(background.motions, background.loads, strict=True)
    ])._replace(largest=0.4)  # fmt: skip


def stribeck_friction(background: Background, joint: int, rng: np.random.Generator) -> Added:
    usual = _usual(background, joint)
    fade, power = rng.uniform(0.1, 0.4) * usual, rng.choice([1.0, 2.0])
    return _one(background, joint, [
        _sign(v, usual) * np.exp(-np.abs(v / fade) ** power)
        for v in (motion.velocity[:, joint] for motion in background.motions)
    ])  # fmt: skip


def nonlinear_viscous_friction(background: Background, joint: int, rng: np.random.Generator) -> Added:
    usual, power = _usual(background, joint), rng.choice([0.35, 1.8, 2.5])
    return _one(background, joint, [
        np.sign(v) * np.abs(v / usual) ** power
        for v in (motion.velocity[:, joint] for motion in background.motions)
    ])  # fmt: skip


def friction_asymmetry(background: Background, joint: int, rng: np.random.Generator) -> Added:
    usual, side = _usual(background, joint), rng.choice([-1.0, 1.0])
    return _one(background, joint, [
        np.maximum(side * v / usual, 0.0) * side
        for v in (motion.velocity[:, joint] for motion in background.motions)
    ])  # fmt: skip


def position_dependent_friction(background: Background, joint: int, rng: np.random.Generator) -> Added:
    usual = _usual(background, joint)
    low, high = _range(background, joint)
    spot, width = rng.uniform(low + 0.2 * (high - low), high - 0.2 * (high - low)), 0.12 * (high - low)
    return _one(background, joint, [
        _sign(motion.velocity[:, joint], usual) * np.exp(-(((motion.position[:, joint] - spot) / width) ** 2))
        for motion in background.motions
    ])  # fmt: skip


def torque_ripple(background: Background, joint: int, rng: np.random.Generator) -> Added:
    usual = _usual(background, joint)
    low, high = _range(background, joint)
    # A wave of 1 to 4 Hz at the usual speed, and more than one and a half within the joint's range.
    order = max(2.0 * np.pi * rng.uniform(1.0, 4.0) / usual, 4.0 * np.pi / (high - low))
    phase = rng.uniform(0.0, 2.0 * np.pi)
    return _one(background, joint, [
        np.sin(order * motion.position[:, joint] + phase) for motion in background.motions
    ])  # fmt: skip


def joint_spring(background: Background, joint: int, rng: np.random.Generator) -> Added | None:
    """A hose that pulls the more the farther it is bent, by a tenth of the torque or two."""
    low, high = _range(background, joint)
    if high - low > 2.0 * np.pi:
        return None
    rest = rng.uniform(low, high)
    stretch = [(motion.position[:, joint] - rest) / (high - low) for motion in background.motions]
    return _one(background, joint, [s + s**3 for s in stretch])._replace(most=0.2)


def hysteresis(background: Background, joint: int, rng: np.random.Generator) -> Added:
    """Stops in parallel, which slide one after the other, less the dry friction that they become."""
    low, high = _range(background, joint)
    reach = rng.uniform(0.02, 0.05) * (high - low) * np.array([0.3, 1.0, 2.0])
    torques = []
    for motion in background.motions:
        steps, held = np.diff(motion.position[:, joint], prepend=motion.position[0, joint]), np.zeros(3)
        rows = np.zeros(len(steps))
        for row, step in enumerate(steps):
            held = np.clip(held + step / reach, -1.0, 1.0)
            rows[row] = held.mean()
        torques.append(rows)
    return _one(background, joint, torques)


def kinematic_coupling(background: Background, joint: int, rng: np.random.Generator) -> Added | None:
    """The motor of this joint turns with the one before it too; its friction acts on both."""
    if joint == 0:
        return None
    ratio = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 1.2)
    torques = []
    for motion in background.motions:
        turned = motion.velocity[:, joint] + ratio * motion.velocity[:, joint - 1]
        usual = float(np.sqrt(np.mean(turned**2)))
        drag = 0.5 * _sign(turned, usual) + 0.5 * turned / usual
        torque = np.zeros_like(motion.position)
        torque[:, joint], torque[:, joint - 1] = drag, ratio * drag
        torques.append(torque)
    return Added(torques, (joint - 1, joint))


def drive_gain_saturation(background: Background, joint: int, rng: np.random.Generator) -> Added | None:
    """Iron saturates: more current for the same torque, with its cube; where currents are recorded."""
    if any(effort(run) == "torque" for _, run in background.runs):
        return None
    smooth = [
        _slow(torque[:, joint], m.time)
        for torque, m in zip(background.torques, background.motions, strict=True)
    ]
    peak = max(float(np.abs(one).max()) for one in smooth)
    return _one(background, joint, [(one / peak) ** 3 for one in smooth])


def current_crosstalk(background: Background, joint: int, rng: np.random.Generator) -> Added | None:
    others = [k for k in range(background.model.robot.dof) if k != joint]
    if not others:
        return None
    other = int(rng.choice(others))
    return _one(background, joint, [torque[:, other] for torque in background.torques])._replace(largest=0.3)


def time_delay(background: Background, joint: int, rng: np.random.Generator) -> Added:
    """All torques later or earlier by some milliseconds; of the size that it has."""
    delay = rng.choice([-1.0, 1.0]) * rng.uniform(2e-3, 8e-3)
    return Added([
        np.stack([np.interp(motion.time - delay, motion.time, one) for one in torque.T], axis=1) - torque
        for torque, motion in zip(background.torques, background.motions, strict=True)
    ], (), sized=True)  # fmt: skip


def contact_event(background: Background, joint: int, rng: np.random.Generator) -> Added | None:
    """One push at the flange, in one run."""
    robot = background.model.robot
    if robot.dof < 3:
        return None
    torques = [np.zeros_like(motion.position) for motion in background.motions]
    fitted = [k for k, (role, _) in enumerate(background.runs) if role == "identify"]
    place = int(rng.choice(fitted))
    motion = background.motions[place]
    start = rng.uniform(0.2, 0.7) * motion.time[-1]
    rows = np.flatnonzero((motion.time >= start) & (motion.time < start + rng.uniform(0.4, 0.8)))
    torques[place][rows] = push_torque(robot.kinematics, motion.position[rows], rng.normal(size=3))
    return Added(torques, ())


def push_torque(kinematics: pin.Model, positions: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Torque (t, n) that holds positions (t, n) against a force on the last link, in the base's axes."""
    data, last, torque = kinematics.createData(), kinematics.njoints - 1, []
    for position in positions:
        jacobian = pin.computeJointJacobian(kinematics, data, position, last)
        torque.append(-(data.oMi[last].rotation @ jacobian[:3]).T @ force)
    return np.array(torque)


def _slow(torque: np.ndarray, time: np.ndarray) -> np.ndarray:
    rate = 1.0 / float(np.median(np.diff(time)))
    return signal.sosfiltfilt(signal.butter(4, min(20.0, 0.4 * rate), fs=rate, output="sos"), torque, axis=0)


def _range(background: Background, joint: int) -> tuple[float, float]:
    every = np.concatenate([motion.position[:, joint] for motion in background.motions])
    return float(every.min()), float(every.max())


EFFECTS: dict[str, Effect] = {
    effect.__name__: effect
    for effect in (
        load_dependent_friction, stribeck_friction, nonlinear_viscous_friction, friction_asymmetry,
        position_dependent_friction, torque_ripple, joint_spring, hysteresis, kinematic_coupling,
        drive_gain_saturation, current_crosstalk, time_delay, contact_event,
    )
}  # fmt: skip
"""Name in the vocabulary -> its torque."""
