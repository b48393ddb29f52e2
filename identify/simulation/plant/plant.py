"""Plant: an arm of any model that follows commands as a real one does."""

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
"""In which friction by load and acceleration agree: each leaves a tenth, its coefficient, of the gap."""

Watched = Callable[[np.ndarray], Iterable[np.ndarray]]
"""Hands on rows one by one."""


class Measured(NamedTuple):
    """What the sensors measure, each of shape (n,).

    Attributes:
        position: Position of the motors, seen from the joints [rad].
        velocity: As the drives estimate it from the position [rad/s].
        current: [A].
        temperature: [degC].
        link_position: Position of the links behind the gears, as a second encoder has it [rad].
    """

    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    temperature: np.ndarray
    link_position: np.ndarray


@dataclass(frozen=True)
class Integration:
    """How finely time is cut: longest step of the equations of motion, and block of one inertia [s]."""

    step: float = 1e-3
    block: float = 2e-3


class Plant:
    """A simulated arm with its drives, at rest in equilibrium to begin with.

    Args:
        model: The arm as it is; every effect of it acts, and its measurements are those of the sensors.
        values: Its parameters, shape (p,).
        gain: Its drive gains, shape (n,) [N m/A].
        start: Position of the motors, seen from the joints, shape (n,) [rad].
        control: Gains and limits of the drives.
        sensors: What they add; nothing by default.
        transmission: That of the model by default.
        thermal: As warm as it is by default.
        payload: Name of the body that is carried; empty for none.
        integration: Steps.
        seed: Seed of the noise.

    Raises:
        WrongShape: Values or a start that do not fit the model.
        RobotError: An arm that cannot move.
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
        gain, start = (_one_a_joint(model, what, a) for what, a in (("gain", gain), ("start", start)))
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
        asked = start + np.linalg.solve(robot.coupling, self._servo.error_for(holding))
        self._path = CommandPath(asked)
        self._reference = self._servo.reference(asked, np.zeros(n))
        self._make_ready()
        limit = np.minimum(sensors.current_limit, model.current_limit)
        late = sensors.current_delay + model.delay
        older = max(0.0, -float(np.min(late)))  # by which positions are shown later than the newest current
        self._past = Past(np.append(np.full(len(self._state.position), older), late + older), self._now())
        self._readings = Readings(replace(sensors, current_limit=limit), start, self._motor_current(), seed)
        seen, link = self._readings, self._links @ self._state.position
        warm = seen.warmth(self._temperature)
        self._measured = Measured(seen.position, seen.velocity, seen.current, warm, link)

    def _at_rest(
        self, start: np.ndarray, transmission: Transmission, to_motors: np.ndarray
    ) -> tuple[State, np.ndarray]:
        """Standing still with the motors at the start, and the torque (n,) [N m] by which they hold that."""
        links = start
        for _ in range(100):  # half of what is missing each time: gears that bend shift what they bear
            on_links, on_motors = self._forces.holding(links, start, self._temperature)
            links = links + 0.5 * (start - transmission.twist(on_links) - links)
        holding = to_motors @ (on_links + on_motors)
        position = np.concatenate([links, start[transmission.elastic]])
        still = np.zeros(len(position))
        self._forces.remember(position)
        state = Joints(position, still, still)
        self._here, self._inertia = self._forces.at(state, position, self._temperature)
        solve(self._inertia, position)  # raises where there is nothing to accelerate
        return State(position, still, still, self._servo.integral_for(holding)), holding

    def _make_ready(self) -> None:
        """Make a step that does not count: where steps are compiled, now, and not in a tick of real time."""
        one = stepping(self._servo, self._springs, self._integration.step)
        one(self._state, self._inertia, self._here, self._here, self._reference[None])

    def measure(self) -> Measured:
        """What its sensors measure now."""
        return self._measured

    def step(self, position: np.ndarray, velocity: np.ndarray | None, seconds: float) -> None:
        """Follow a command (n,) [rad], [rad/s], which is reached at the end of these seconds.

        Without a velocity the drives take it from successive positions.
        """
        self.follow(position[None], None if velocity is None else velocity[None], seconds)

    def follow(
        self, position: np.ndarray, velocity: np.ndarray | None, seconds: float, watched: Watched = iter
    ) -> Measured:
        """Follow commands (t, n) one after the other, as if by `step`; what its sensors measure, each (t, n).

        It is faster, for what is before and behind the arm's motion is done for all commands at once.
        `watched` hands on what to follow, tick by tick, and may show how far that is.
        """
        cut = self._cut(seconds)
        references = self._servo.reference(*self._path.along(position, velocity, cut))
        ticks = [self._tick(reference, cut) for reference in watched(references)]
        arm, current, temperature = (np.array(rows) for rows in zip(*ticks, strict=True))
        seen = self._readings.see(arm @ self._motors.T, current, seconds)
        measured = Measured(*seen, self._readings.warmth(temperature), arm @ self._links.T)
        self._measured = Measured(*(values[-1] for values in measured))
        return measured

    def release(self) -> None:
        """Take the drives' torque away for good; without brakes, the arm drops."""
        self._servo.release()
        self._cuts.clear()

    def truth(self) -> Motion:
        """How the motors really move now, a motion of one sample: no sensor measures it."""
        temperature, joints = self._temperature, Joints(*self._state[:3])
        spring = springs(self._springs, joints.position, joints.velocity, 0.0)[0]
        pull = self._servo.turns.T @ self._torque() - spring
        for _ in range(ROUNDS if self._forces.loaded else 1):
            here, inertia = self._forces.at(joints, joints.position, temperature)
            joints = joints._replace(acceleration=np.linalg.solve(inertia, pull - here.force))
        position, velocity, acceleration = ((self._motors @ one)[None] for one in joints)
        now, warm = np.zeros(1), temperature[None]
        return Motion.of(now, position, velocity, acceleration, None, warm, self._payload)

    def _tick(self, references: np.ndarray, cut: Cut) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Make all steps of a tick; its coordinates then, current in the sensors, and temperature."""
        for block in range(cut.blocks):
            steps, middle, end = cut.split(block)
            self._advance(references[steps], references[middle], cut)
            self._reference = references[end]
            self._past.add(self._now(), cut.steps * cut.step)
        heat, place = self._forces.friction * (self._motors @ self._state.velocity), len(self._state.position)
        current = self._past.newest[place:]
        self._temperature = self._thermal.after(self._temperature, current, heat, cut.seconds)
        position, current = np.split(self._past.delayed(), [place])
        return position, current, self._temperature

    def _advance(self, reference: np.ndarray, middle: np.ndarray, cut: Cut) -> None:
        """Make the steps of one block with references (k, n), and with one in their middle (1, n).

        Foresee its end, then go there: effects are asked once a block, where it was foreseen to end, and
        linearly from there where it ended.
        """
        state, here, (steps, whole) = self._state, self._here, self._steppings[cut.seconds]
        foreseen = whole(state, self._inertia, here, here, middle)
        later = 1.5 * foreseen.position - 0.5 * state.position
        end, inertia = self._forces.at(Joints(*foreseen[:3]), later, self._temperature)
        self._state = steps(state, self._inertia, here, end, reference)
        self._forces.remember(self._state.position)
        self._here, self._inertia = end.moved(self._state.velocity), inertia

    def _torque(self) -> np.ndarray:
        """Torque of the motors at this instant, seen from the joints, shape (n,) [N m]."""
        return self._servo.torque(self._reference, self._state)

    def _now(self) -> np.ndarray:
        """Its coordinates [rad] and the currents of its motors [A], shape (x + n,)."""
        return np.append(self._state.position, self._motor_current())

    def _motor_current(self) -> np.ndarray:
        return self._control.current(self._recorded(self._torque()), self._gain)

    def _cut(self, seconds: float) -> Cut:
        if seconds not in self._cuts:
            cut = Cut.of(seconds, self._integration.step, self._integration.block)
            lengths = (cut.step, cut.step * cut.steps)
            one, whole = (stepping(self._servo, self._springs, length) for length in lengths)
            self._cuts[seconds], self._steppings[seconds] = cut, (one, whole)
        return self._cuts[seconds]


def _one_a_joint(model: Model, what: str, given: np.ndarray) -> np.ndarray:
    array, n = np.array(given, float), model.robot.dof
    if array.shape != (n,) or not np.all(np.isfinite(array)):
        raise WrongShape(f"{model.robot.name}: {what} is {given}; expected {n} numbers, one a joint")
    return array
