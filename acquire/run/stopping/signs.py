"""Signs: comparisons of the arm's motion with the motion that a stop should allow by then.

Times are by the host's clock: if the controller's clock stopped, escalation would stop with it.
"""

from collections import deque
from collections.abc import Callable

import numpy as np

from exidyn.drivers import Command, Sample
from exidyn.drivers.values import any_of
from exidyn.identification.arm.robot import Limits, Robot

from .escalation import (
    SETTLED,
    UNITS,
    WATCHED,
    Sight,
    Sign,
    State,
    allowed_speed,
    overdue,
    sign_limits,
    stopping_distance,
)
from .history import Excess, History
from .stop import EMERGENCY, RESTING, Standstill, unknown_at_end
from .watch import WatchLimits

WINDOW = 0.05
"""Averaging window of speeds [s]."""
MOVING = 0.1
"""Speed above which a joint counts as moving [rad/s]: three steps per window of the coarsest encoder
(1.5 mrad) of a serial servo. Slower motion is detected by its distance."""
LIMP_SHARE = 0.05
"""Share of the maximum torque below which a drive is considered off [-]: friction alone takes that much."""
MIN_SAMPLES = 3
"""Minimum number of samples that show a sign, however far apart they are."""


class Signs:
    """Detects signs that a stop does not work, in every cycle.

    Args:
        robot: Robot, for names and units of the joints.
        limits: Limits of the robot, finite in velocity and acceleration.
        current: Maximum current, shape (n,) [A]; infinite where unknown.
        watch: Limits of the run's monitors.
        cycle: Sampling period [s].
        history: Samples and commands of the run.
        flange: Function that returns the flange position, shape (3,) [m], from joint positions (n,), or None.
    """

    def __init__(
        self,
        robot: Robot,
        limits: Limits,
        current: np.ndarray,
        watch: WatchLimits,
        cycle: float,
        history: History,
        flange: Callable[[np.ndarray], np.ndarray] | None = None,
    ) -> None:
        n = robot.dof
        self._robot, self._watch, self._current = robot, watch, current
        self._history, self._flange, self._torque = history, flange, limits.torque
        self._lower, self._upper = limits.position_lower, limits.position_upper
        self._deceleration = np.minimum(limits.acceleration, -limits.acceleration_lower)
        self._fastest = np.maximum(limits.velocity, -limits.velocity_lower)
        self._window = max(round(WINDOW / cycle), 2)
        self._least, self._silence = self._window * cycle, watch.silent_cycles(cycle)
        memory = max(round(watch.delay / cycle), 1)
        self._commanded = deque([np.zeros(n)], maxlen=memory + self._window)
        self._unknown = np.full(n, np.nan)
        self._velocity = self._first = self._rest = self._initial_speed = self._unknown
        self._zero = self._distance = np.zeros(n)
        self._rest_position: np.ndarray | None = None
        self._position: np.ndarray | None = None
        self._state, self._entered = State.LISTENING, 0.0
        self._excess = {sign: Excess(n) for sign in WATCHED[self._state]}
        self._limits = {sign: np.full(n, limit) for sign, limit in sign_limits(watch).items()}
        self._measures: dict[Sign, Callable[[Sample], np.ndarray]] = {
            Sign.ADRIFT: lambda sample: np.abs(sample.position - self._first),
            Sign.FASTER: self._faster,
            Sign.BEHIND: lambda sample: history.tracking_error,
            Sign.AWAY: lambda sample: history.tracking_error,
            Sign.OUTWARD: self._outward,
            Sign.MOVES_ON: self._moves_on,
            Sign.CREEPS: lambda sample: self._distance,
            Sign.FLANGE_CREEPS: self._flange_creeps,
        }

    def look(self, sample: Sample, sent: Command | None, state: State) -> dict[Sign, Sight]:
        """Signs of a state that are seen in a cycle with this sample and sent command."""
        self._history.add(sample, sent)
        time = self._history.time
        self._measure(sample, sent)
        if state is not self._state:
            self._enter(state, time)
        signs = WATCHED[state]
        if not signs:
            return {}
        self._note_rest_position(state, time)
        self._measure_creep(sample)
        sights = {sign: self._sight(sign, sample, time) for sign in signs}
        return {sign: sight for sign, sight in sights.items() if sight is not None}

    @property
    def calm(self) -> bool:
        """Whether no joint moves and no sign is seen, however briefly."""
        if self._history.before(self._window) is None or np.any(np.abs(self._velocity) > MOVING):
            return False
        if any(excess.counting for excess in self._excess.values()):
            return False
        return bool(np.all(np.abs(self._history.residual_speed()) <= RESTING))  # false while it is unknown

    def at_end(self) -> Standstill:
        """Determine from the last samples whether the arm stands."""
        history, joints = self._history, self._robot.joints
        speed = np.where(history.silent(self._silence), np.nan, np.abs(history.residual_speed()))
        if np.any(speed > RESTING):
            joint = int(np.nanargmax(speed))
            unit = self._robot.unit(joint, "rad/s")
            name, fastest = joints[joint], float(speed[joint])
            text = f"{name} STILL MOVES at {fastest:.2g} {unit} {self._state.value}: {EMERGENCY}"
            return Standstill(True, text, name, fastest, unit)
        if np.isnan(speed).any():
            names = [joints[int(j)] for j in np.flatnonzero(np.isnan(speed))]
            return unknown_at_end(f"nothing is received from {', '.join(names)}")
        return self._standing()

    def _standing(self) -> Standstill:
        """Standstill of an arm at rest: at its last command, up to the stopping distance, or elsewhere."""
        last = self._history.last_command
        if last is None:
            return Standstill(False, "the arm stands")
        away = np.abs(self._history.mean() - last.position)
        braking = stopping_distance(np.abs(last.velocity), self._deceleration)
        limit = self._watch.tracking + (braking if self._state in (State.QUICK, State.OFF) else 0.0 * braking)
        joint = int(np.argmax(away - limit))
        if away[joint] <= limit[joint]:
            return Standstill(False, "the arm stands")
        unit, name = self._robot.unit(joint, "rad"), self._robot.joints[joint]
        text = (
            f"the arm stands, but {name} is {away[joint]:.3g} {unit} from its last command, limit "
            f"{limit[joint]:.3g} {unit}: it moved after that command, did not follow it, or its position is "
            "wrong. Check the arm before the next run"
        )
        return Standstill(False, text, name, away=float(away[joint]))

    def _enter(self, state: State, time: float) -> None:
        """Start to look for the signs of another state."""
        if state is State.QUICK:
            speed = np.abs(self._velocity)
            self._initial_speed = np.where(np.isnan(speed), self._fastest, speed)
        self._state, self._entered, self._rest_position = state, time, None
        self._excess = {sign: self._excess.get(sign) or Excess(self._robot.dof) for sign in WATCHED[state]}

    def _note_rest_position(self, state: State, time: float) -> None:
        """Store the position of the arm once it should be at rest."""
        since = time - self._entered - SETTLED
        if self._rest_position is None and since > 0.0:
            if state is not State.QUICK or overdue(self._initial_speed, self._deceleration, since).all():
                self._rest_position = self._history.mean()

    def _sight(self, sign: Sign, sample: Sample, time: float) -> Sight | None:
        value = self._measures[sign](sample)
        limit, excess = self._limits[sign], self._excess[sign]
        if not excess.add(value, limit, time):
            return None
        seconds = np.where(excess.count >= MIN_SAMPLES, time - excess.since, -1.0)
        j = int(np.argmax(seconds))
        if seconds[j] < 0.0 or np.isnan(value[j]):
            return None
        unit = self._robot.unit(j, UNITS.get(sign, "rad"))
        return Sight(self._robot.joints[j], float(value[j]), float(limit[j]), float(seconds[j]), unit)

    def _measure(self, sample: Sample, sent: Command | None) -> None:
        position, earlier = sample.position, self._history.before(self._window)
        if earlier is not None:
            start_time, start = 1e-9 * earlier[0], earlier[1]
            self._velocity = (position - start) / max(self._history.time - start_time, self._least)
        if sent is not None:
            self._commanded.append(np.abs(sent.velocity))
        if self._state is State.LISTENING:
            self._first = np.where(np.isnan(self._first), position, self._first)
            # An arm may start outside its limits and move back inside.
            self._lower, self._upper = np.fmin(self._lower, position), np.fmax(self._upper, position)

    def _faster(self, sample: Sample) -> np.ndarray:
        """Speed of each joint that is away from its command; the limit follows from recent commanded speeds.

        A soft arm that swings around its commanded position is not away from it.
        """
        self._limits[Sign.FASTER] = MOVING + self._watch.speed * np.max(self._commanded, axis=0)
        error = self._history.tracking_error
        unknown = 0.0 * error  # NaN where unknown
        return np.where(error > self._watch.tracking, np.abs(self._velocity), unknown)

    def _outward(self, sample: Sample) -> np.ndarray:
        """Distance beyond the position limits of each joint that moves further outward."""
        below, above = self._lower - sample.position, sample.position - self._upper
        beyond = np.where(self._velocity < -MOVING, below, np.where(self._velocity > MOVING, above, 0.0))
        return np.asarray(beyond + 0.0 * self._velocity)

    def _moves_on(self, sample: Sample) -> np.ndarray:
        """Distance since a quick stop should have ended, for joints that do not slow down as required."""
        since, speed = self._history.time - self._entered, np.abs(self._velocity)
        if not overdue(np.zeros(1), np.ones(1), since)[0]:  # the drives may not have reacted yet
            self._initial_speed = np.fmax(self._initial_speed, speed)
        due = overdue(self._initial_speed, self._deceleration, since)
        self._rest = np.where(due & np.isnan(self._rest), sample.position, self._rest)
        distance = np.where(due, np.abs(sample.position - self._rest), 0.0)
        allowed = allowed_speed(self._initial_speed, self._deceleration, since) + MOVING
        driven = (speed > allowed) & ~self._limp(sample)
        return np.where(np.isnan(speed), np.nan, np.where(driven, distance, 0.0))

    def _measure_creep(self, sample: Sample) -> None:
        """Measure the distance of joints that still move in one direction after they should be at rest."""
        self._distance, self._position = self._zero, self._rest_position
        if self._rest_position is None:
            return
        creeping = self._history.directed() & ~self._limp(sample)
        if any_of(creeping):
            self._position = np.where(creeping, self._history.mean(), self._rest_position)
            self._distance = np.nan_to_num(np.abs(self._position - self._rest_position))

    def _flange_creeps(self, sample: Sample) -> np.ndarray:
        """Distance of the flange since the arm should be at rest, attributed to the joint that moved most."""
        start, end = self._rest_position, self._position
        if self._distance is self._zero or self._flange is None or start is None or end is None:
            return self._zero
        if np.isnan(start).any() or np.isnan(end).any():
            return self._zero
        value = np.zeros(self._robot.dof)
        value[int(np.argmax(self._distance))] = np.linalg.norm(self._flange(end) - self._flange(start))
        return value

    def _limp(self, sample: Sample) -> np.ndarray:
        """Whether each joint falls by its weight, shape (n,): a drive has a fault, and the joint no torque.

        Removing the torque would not stop these joints, and would make the others drop too.
        """
        if not sample.fault:
            return np.zeros(self._robot.dof, bool)
        by_current = np.isfinite(self._current) & (np.abs(sample.current) < LIMP_SHARE * self._current)
        by_torque = np.isfinite(self._torque) & (np.abs(sample.torque) < LIMP_SHARE * self._torque)
        return by_current | by_torque
