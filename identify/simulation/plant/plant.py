"""Plant: a simulated arm of any model that follows commands like a real arm."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...arm.motion import Motion
from ...errors import WrongShape
from ...model import Model
from .drives import CommandPath, Cut, DriveControl, Servo, State, Steps, stepping
from .forces import ArmForces, Joints
from .gears import Thermal, Transmission, with_motors
from .sensors import Past, Readings, Sensors
from .steps import solve, springs

ROUNDS = 5
"""Iterations between load-dependent friction and acceleration: each reduces the error to about a tenth, the
friction coefficient."""

Watched = Callable[[np.ndarray], Iterable[np.ndarray]]
"""Wrapper of an iteration over rows, for example to show progress."""


class Measured(NamedTuple):
    """Sensor measurements, each of shape (n,)."""

    position: np.ndarray  # motor positions on the joint side [rad]
    velocity: np.ndarray  # velocity that the drives estimate from the position [rad/s]
    current: np.ndarray  # motor current [A]
    temperature: np.ndarray  # joint temperature [degC]
    link_position: np.ndarray  # link positions behind the gears, as a second encoder measures them [rad]


@dataclass(frozen=True)
class Integration:
    """Maximum step of the equations of motion, and maximum duration of a block with constant inertia [s]."""

    step: float = 1e-3
    block: float = 2e-3


class Plant:
    """A simulated arm with its drives, initially at rest in equilibrium.

    Args:
        model: Model of the real arm; all of its effects act, and its measurement effects act on the sensors.
        values: Parameters of the model, shape (p,).
        gain: Drive gains, shape (n,) [N m/A].
        start: Initial motor positions on the joint side, shape (n,) [rad].
        control: Gains and limits of the drives.
        sensors: Noise and resolution of the sensors; exact by default.
        transmission: Gears; those of the model by default.
        thermal: Thermal model; a constant temperature by default.
        payload: Name of the payload; empty for none.
        integration: Maximum steps of the integration.
        seed: Seed of the noise.

    Raises:
        WrongShape: If values or the start do not fit the model.
        RobotError: If the arm cannot move, for lack of inertia.
    """

    def __init__(
        self,
        model: Model,
        values: np.ndarray,
        gain: np.ndarray,
        start: np.ndarray,
        control: DriveControl,
        sensors: Sensors | None = None,
        transmission: Transmission | None = None,
        thermal: Thermal | None = None,
        payload: str = "",
        integration: Integration = Integration(),  # noqa: B008
        seed: int = 0,
    ) -> None:
        robot, n = model.robot, model.robot.dof
        gain, start = _one_per_joint(model, "gain", gain), _one_per_joint(model, "start", start)
        sensors, thermal = sensors or Sensors.exact(n), thermal or Thermal.constant(n)
        transmission = transmission or Transmission.of(model)
        model, values = with_motors(model, values, transmission.elastic)
        self.joints, self._recorded = robot.joints, model.recorded
        self._payload, self._gain, self._control, self._thermal = payload, gain, control, thermal
        self._integration, self._cuts = integration, dict[float, Cut]()
        self._motors, self._links = transmission.motors, transmission.links
        self._temperature = np.full(n, thermal.ambient)
        self._forces = ArmForces(model, values, payload, transmission)
        self._servo = Servo(control, gain, robot.coupling, self._motors)
        self._springs, self._steppings = transmission.springs, dict[float, tuple[Steps, Steps]]()
        self._state, holding = self._at_rest(start, transmission, robot.to_motors)
        commanded = start + np.linalg.solve(robot.coupling, self._servo.error_for(holding))
        self._path = CommandPath(commanded)
        self._reference = self._servo.reference(commanded, np.zeros(n))
        # A discarded step, so that compilation happens now and not during real-time control.
        make_steps = stepping(self._servo, self._springs, integration.step)
        make_steps(self._state, self._inertia, self._here, self._here, self._reference[None])
        limit = np.minimum(sensors.current_limit, model.current_limit)
        current_delay = sensors.current_delay + model.delay
        # A negative delay of the current is a delay of the positions.
        position_delay = max(0.0, -float(np.min(current_delay)))
        delays = np.append(np.full(len(self._state.position), position_delay), current_delay + position_delay)
        self._past = Past(delays, self._now())
        self._readings = Readings(replace(sensors, current_limit=limit), start, self._motor_current(), seed)
        readings, link = self._readings, self._links @ self._state.position
        temperature = readings.round_temperature(self._temperature)
        self._measured = Measured(readings.position, readings.velocity, readings.current, temperature, link)

    def _at_rest(
        self, start: np.ndarray, transmission: Transmission, to_motors: np.ndarray
    ) -> tuple[State, np.ndarray]:
        """State at rest with the motors at the start, and the torque (n,) [N m] that holds them there."""
        links = start
        for _ in range(100):  # half a correction each time, because the twist of a gear changes its load
            on_links, on_motors = self._forces.holding(links, start, self._temperature)
            links = links + 0.5 * (start - transmission.twist(on_links) - links)
        holding = to_motors @ (on_links + on_motors)
        position = np.concatenate([links, start[transmission.elastic]])
        still = np.zeros(len(position))
        self._forces.remember(position)
        state = Joints(position, still, still)
        self._here, self._inertia = self._forces.at(state, position, self._temperature)
        solve(self._inertia, position)  # raises if there is no inertia
        return State(position, still, still, self._servo.integral_for(holding)), holding

    def measure(self) -> Measured:
        """Current sensor measurements."""
        return self._measured

    def step(self, position: np.ndarray, velocity: np.ndarray | None, seconds: float) -> None:
        """Follow a command (n,) [rad], [rad/s] that is to be reached after some seconds.

        Without a commanded velocity, the drives differentiate successive positions.
        """
        self.follow(position[None], None if velocity is None else velocity[None], seconds)

    def follow(
        self, position: np.ndarray, velocity: np.ndarray | None, seconds: float, watched: Watched = iter
    ) -> Measured:
        """Follow commands (t, n) one by one, as if by `step`, and return the measurements, each (t, n).

        It is faster than `step`, because command paths and sensors are computed for all commands at once.
        `watched` wraps the iteration over commands, for example to show progress.
        """
        cut = self._cut(seconds)
        references = self._servo.reference(*self._path.along(position, velocity, cut))
        ticks = [self._tick(reference, cut) for reference in watched(references)]
        arm, current, temperature = (np.array(rows) for rows in zip(*ticks, strict=True))
        readings = self._readings.see(arm @ self._motors.T, current, seconds)
        measured = Measured(*readings, self._readings.round_temperature(temperature), arm @ self._links.T)
        self._measured = Measured(*(values[-1] for values in measured))
        return measured

    def release(self) -> None:
        """Switch off the drives' torque permanently; without brakes, the arm drops."""
        self._servo.release()
        self._cuts.clear()

    def truth(self) -> Motion:
        """True current motion of the motors, without sensor errors, as a motion of one sample."""
        temperature, joints = self._temperature, Joints(*self._state[:3])
        spring = springs(self._springs, joints.position, joints.velocity, 0.0)[0]
        pull = self._servo.turns.T @ self._torque() - spring
        for _ in range(ROUNDS if self._forces.loaded else 1):
            here, inertia = self._forces.at(joints, joints.position, temperature)
            joints = joints._replace(acceleration=np.linalg.solve(inertia, pull - here.force))
        position, velocity, acceleration = ((self._motors @ values)[None] for values in joints)
        time, temperatures = np.zeros(1), temperature[None]
        return Motion.of(time, position, velocity, acceleration, None, temperatures, self._payload)

    def _tick(self, references: np.ndarray, cut: Cut) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Make all steps of a command period; return sensed coordinates, sensed current, and temperature."""
        for block in range(cut.blocks):
            steps, middle, end = cut.split(block)
            self._advance(references[steps], references[middle], cut)
            self._reference = references[end]
            self._past.add(self._now(), cut.steps * cut.step)
        heat = self._forces.friction * (self._motors @ self._state.velocity)
        coordinates = len(self._state.position)
        current = self._past.newest[coordinates:]
        self._temperature = self._thermal.after(self._temperature, current, heat, cut.seconds)
        position, current = np.split(self._past.delayed(), [coordinates])
        return position, current, self._temperature

    def _advance(self, reference: np.ndarray, middle: np.ndarray, cut: Cut) -> None:
        """Make the steps of one block with references (k, n), and with one in their middle (1, n).

        The end of the block is predicted first. Effects are evaluated once per block, at the predicted end,
        and extrapolated linearly to the actual end.
        """
        state, here, (steps, block_step) = self._state, self._here, self._steppings[cut.seconds]
        predicted = block_step(state, self._inertia, here, here, middle)
        later = 1.5 * predicted.position - 0.5 * state.position
        end, inertia = self._forces.at(Joints(*predicted[:3]), later, self._temperature)
        self._state = steps(state, self._inertia, here, end, reference)
        self._forces.remember(self._state.position)
        self._here, self._inertia = end.moved(self._state.velocity), inertia

    def _torque(self) -> np.ndarray:
        """Current motor torque on the joint side, shape (n,) [N m]."""
        return self._servo.torque(self._reference, self._state)

    def _now(self) -> np.ndarray:
        """Current coordinates [rad] and motor currents [A], shape (x + n,)."""
        return np.append(self._state.position, self._motor_current())

    def _motor_current(self) -> np.ndarray:
        return self._control.current(self._recorded(self._torque()), self._gain)

    def _cut(self, seconds: float) -> Cut:
        if seconds not in self._cuts:
            cut = Cut.of(seconds, self._integration.step, self._integration.block)
            durations = (cut.step, cut.step * cut.steps)
            steps, block_step = (stepping(self._servo, self._springs, duration) for duration in durations)
            self._cuts[seconds], self._steppings[seconds] = cut, (steps, block_step)
        return self._cuts[seconds]


def _one_per_joint(model: Model, name: str, values: np.ndarray) -> np.ndarray:
    array, n = np.array(values, float), model.robot.dof
    if array.shape != (n,) or not np.all(np.isfinite(array)):
        raise WrongShape(
            f"{model.robot.name}: {name} is {values}; expected {n} finite numbers, one per joint"
        )
    return array
