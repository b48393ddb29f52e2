"""Signs: comparisons of the arm's motion with the motion that a stop should allow by then.

Times are by the host's clock: if the controller's clock stopped, escalation would stop with it.
"""

from collections import deque
from collections.abc import Callable, Sequence

import numpy as np

from exidyn.drivers import Command, Sample
from exidyn.drivers.values import any_of
from exidyn.identification.arm.robot import Limits

from .escalation import SETTLED, UNITS, WATCHED, Sight, Sign, State, allowed_speed, overdue, stopping_distance
from .monitors import TrackingError
from .standstill import EMERGENCY, RESTING, Drift, Standstill, unknown_at_end
from .stop import UnitOf, revolute_unit
from .watch import WatchLimits

WINDOW = 0.05
"""Averaging window of speeds [s]."""
MOVING = 0.1
"""Speed above which a joint counts as moving [rad/s]: three steps per window of the coarsest encoder
(1.5 mrad) of a serial servo. Slower motion is detected by its distance."""
CREEP_LIMIT = 0.1
"""Distance that no load, spring or swing explains [rad]: six degrees."""
SWING_LIMIT = 0.2
"""Distance beyond any swing of an arm on soft springs after a quick stop [rad]: twice `CREEP_LIMIT`."""
FLANGE_LIMIT = 0.01
"""Distance of the flange that counts as motion [m], in one direction and after the arm should be at rest: a
person who holds the flange would notice it, and a settling position loop moves less."""
BRAKING_FACTOR = 2.0
"""Multiple of the tracking limit allowed during a controlled stop, which may still reduce the error [-]."""
LIMP_SHARE = 0.05
"""Share of the maximum torque below which a drive is considered off [-]: friction alone takes that much."""
MIN_SAMPLES = 3
"""Minimum number of samples that show a sign, however far apart they are."""


class Signs:
    """Detects signs that a stop does not work, in every cycle.

    Args:
        joints: Names of the joints.
        limits: Limits of the robot, finite in velocity and acceleration.
        current: Maximum current, shape (n,) [A]; infinite where unknown.
        watch: Limits of the run's monitors.
        cycle: Sampling period [s].
        unit_of: Function that returns the unit of a joint.
        tracking: Tracking error of the run's watch; created here if None.
        flange: Function that returns the flange position, shape (3,) [m], from joint positions (n,), or None.
    """

    def __init__(
        self,
        joints: Sequence[str],
        limits: Limits,
        current: np.ndarray,
        watch: WatchLimits,
        cycle: float,
        unit_of: UnitOf = revolute_unit,
        tracking: TrackingError | None = None,
        flange: Callable[[np.ndarray], np.ndarray] | None = None,
    ) -> None:
        n = len(joints)
        self._joints, self._watch, self._current = joints, watch, current
        self._unit_of, self._torque = unit_of, limits.torque
        self._lower, self._upper = limits.position_lower, limits.position_upper
        self._deceleration = np.minimum(limits.acceleration, -limits.acceleration_lower)
        self._fastest = np.maximum(limits.velocity, -limits.velocity_lower)
        memory = max(round(watch.delay / cycle), 1)
        self._tracking = tracking or TrackingError(memory)
        self._window = max(round(WINDOW / cycle), 2)
        self._least, self._silence = self._window * cycle, watch.silent_cycles(cycle)
        self._recent = deque[tuple[float, np.ndarray]](maxlen=self._window + 1)
        self._commanded = deque[np.ndarray](maxlen=memory + self._window)
        self._drift = Drift(n, cycle, flange)
        self._unknown = np.full(n, np.nan)
        self._velocity = self._error = self._first = self._rest = self._initial_speed = self._unknown
        self._last_command: Command | None = None
        self._zero = self._distance = np.zeros(n)
        self._rest_position: np.ndarray | None = None
        self._position: np.ndarray | None = None
        self._state, self._entered = State.LISTENING, 0.0
        self._durations = {sign: _Duration(n) for sign in WATCHED[self._state]}
        self._limits = {
            Sign.ADRIFT: np.full(n, CREEP_LIMIT),
            Sign.BEHIND: np.full(n, BRAKING_FACTOR * watch.tracking),
            Sign.AWAY: np.full(n, watch.tracking),
            Sign.OUTWARD: np.full(n, watch.outside),
            Sign.MOVES_ON: np.full(n, SWING_LIMIT),
            Sign.CREEPS: np.full(n, CREEP_LIMIT),
            Sign.FLANGE_CREEPS: np.full(n, FLANGE_LIMIT),
        }
        self._measures: dict[Sign, Callable[[Sample], np.ndarray]] = {
            Sign.ADRIFT: lambda sample: np.abs(sample.position - self._first),
            Sign.FASTER: self._faster,
            Sign.BEHIND: lambda sample: self._error,
            Sign.AWAY: lambda sample: self._error,
            Sign.OUTWARD: self._outward,
            Sign.MOVES_ON: self._moves_on,
            Sign.CREEPS: lambda sample: self._distance,
            Sign.FLANGE_CREEPS: self._flange_creeps,
        }

    def look(self, sample: Sample, sent: Command | None, state: State) -> dict[Sign, Sight]:
        """Signs of a state that are seen in a cycle with this sample and sent command."""
        time = 1e-9 * sample.host_time
        self._measure(sample, sent, time)
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
        if len(self._recent) <= self._window or np.any(np.abs(self._velocity) > MOVING):
            return False
        if any(duration.count.any() for duration in self._durations.values()):
            return False
        return bool(np.all(np.abs(self._drift.speed()) <= RESTING))  # false while the speed is unknown

    def at_end(self) -> Standstill:
        """Determine from the last samples whether the arm stands."""
        silent = self._drift.silent(self._silence)
        speed = np.where(silent, np.nan, np.abs(self._drift.speed()))
        if np.any(speed > RESTING):
            joint = int(np.nanargmax(speed))
            unit = self._unit_of(joint, "rad/s")
            name, fastest = self._joints[joint], float(speed[joint])
            text = f"{name} STILL MOVES at {fastest:.2g} {unit} {self._state.value}: {EMERGENCY}"
            return Standstill(True, text, name, fastest, unit)
        if np.isnan(speed).any():
            names = [self._joints[int(j)] for j in np.flatnonzero(np.isnan(speed))]
            return unknown_at_end(f"nothing is received from {', '.join(names)}")
        return self._standing()

    def _standing(self) -> Standstill:
        """Standstill of an arm at rest: at its last command, up to the stopping distance, or elsewhere."""
        last = self._last_command
        if last is None:
            return Standstill(False, "the arm stands")
        away = np.abs(self._drift.mean() - last.position)
        braking = stopping_distance(np.abs(last.velocity), self._deceleration)
        limit = self._watch.tracking + (braking if self._state in (State.QUICK, State.OFF) else 0.0 * braking)
        joint = int(np.argmax(away - limit))
        if away[joint] <= limit[joint]:
            return Standstill(False, "the arm stands")
        unit, name = self._unit_of(joint, "rad"), self._joints[joint]
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
        self._durations = {
            sign: self._durations.get(sign) or _Duration(len(self._joints)) for sign in WATCHED[state]
        }

    def _note_rest_position(self, state: State, time: float) -> None:
        """Store the position of the arm once it should be at rest."""
        since = time - self._entered - SETTLED
        if self._rest_position is None and since > 0.0:
            if state is not State.QUICK or overdue(self._initial_speed, self._deceleration, since).all():
                self._rest_position = self._drift.mean()

    def _sight(self, sign: Sign, sample: Sample, time: float) -> Sight | None:
        value = self._measures[sign](sample)
        limit = self._limits[sign]
        seconds = self._durations[sign].add(time, value, limit)
        if seconds is None:
            return None
        j = int(np.argmax(seconds))
        if seconds[j] < 0.0 or np.isnan(value[j]):
            return None
        unit = self._unit_of(j, UNITS.get(sign, "rad"))
        return Sight(self._joints[j], float(value[j]), float(limit[j]), float(seconds[j]), unit)

    def _measure(self, sample: Sample, sent: Command | None, time: float) -> None:
        position = sample.position
        self._drift.add(time, position)
        self._recent.append((time, position))
        self._velocity = self._unknown
        if len(self._recent) > self._window:
            start_time, start = self._recent[0]
            self._velocity = (position - start) / max(time - start_time, self._least)
        self._error = self._tracking.of(sample, sent)
        if sent is not None:
            self._last_command = sent
            self._commanded.append(np.abs(sent.velocity))
        if self._state is State.LISTENING:
            self._first = np.where(np.isnan(self._first), position, self._first)
            # An arm may start outside its limits and move back inside.
            self._lower, self._upper = np.fmin(self._lower, position), np.fmax(self._upper, position)

    def _faster(self, sample: Sample) -> np.ndarray:
        """Speed of each joint that is away from its command; the limit follows from recent commanded speeds.

        A soft arm that swings around its commanded position is not away from it.
        """
        commanded = np.max(self._commanded, axis=0) if self._commanded else np.zeros(len(self._joints))
        self._limits[Sign.FASTER] = MOVING + self._watch.speed * commanded
        unknown = 0.0 * self._error  # NaN where unknown
        speed: np.ndarray = np.where(self._error > self._watch.tracking, np.abs(self._velocity), unknown)
        return speed

    def _outward(self, sample: Sample) -> np.ndarray:
        """Distance beyond the position limits of each joint that moves further outward."""
        below, above = self._lower - sample.position, sample.position - self._upper
        beyond = np.where(self._velocity < -MOVING, below, np.where(self._velocity > MOVING, above, 0.0))
        return np.asarray(beyond + 0.0 * self._velocity)

    def _moves_on(self, sample: Sample) -> np.ndarray:
        """Distance since a quick stop should have ended, for joints that do not slow down as required."""
        since, speed = self._recent[-1][0] - self._entered, np.abs(self._velocity)
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
        creeping = self._drift.directed() & ~self._limp(sample)
        if any_of(creeping):
            self._position = np.where(creeping, self._drift.mean(), self._rest_position)
            self._distance = np.nan_to_num(np.abs(self._position - self._rest_position))

    def _flange_creeps(self, sample: Sample) -> np.ndarray:
        """Distance of the flange since the arm should be at rest, attributed to the joint that moved most."""
        if self._distance is self._zero or self._rest_position is None or self._position is None:
            return self._zero
        value, start, end = np.zeros(len(self._joints)), self._rest_position, self._position
        value[int(np.argmax(self._distance))] = self._drift.flange_distance(start, end)
        return value

    def _limp(self, sample: Sample) -> np.ndarray:
        """Whether each joint falls by its weight, shape (n,): a drive has a fault, and the joint no torque.

        Removing the torque would not stop these joints, and would make the others drop too.
        """
        if not sample.fault:
            return np.zeros(len(self._joints), bool)
        by_current = np.isfinite(self._current) & (np.abs(sample.current) < LIMP_SHARE * self._current)
        by_torque = np.isfinite(self._torque) & (np.abs(sample.torque) < LIMP_SHARE * self._torque)
        return by_current | by_torque


class _Duration:
    """Measures how long each joint has exceeded a limit; cycles with unknown values do not interrupt it."""

    def __init__(self, joints: int) -> None:
        self.count = np.zeros(joints, int)
        self._start = np.zeros(joints)
        self._counting = False

    def add(self, time: float, value: np.ndarray, limit: np.ndarray) -> np.ndarray | None:
        """Duration, shape (n,) [s]; -1 within the limit or with too few samples; None for no joint beyond."""
        beyond = value > limit
        if not self._counting and not any_of(beyond):
            return None
        known = ~np.isnan(value)
        self._start = np.where(beyond & (self.count == 0), time, self._start)
        self.count = np.where(beyond, self.count + 1, np.where(known, 0, self.count))
        self._counting = bool(self.count.any())
        return np.where(self.count >= MIN_SAMPLES, time - self._start, -1.0)
