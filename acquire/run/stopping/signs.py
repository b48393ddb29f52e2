"""Signs: what the arm does, held against what a stop should make it do by then.

Time is the host's: a controller whose clock stands still would stop every escalation with it.
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
from .stop import UnitOf, turning
from .watch import WatchLimits

WINDOW = 0.05
"""Time over which a speed is a mean [s]."""
MOVING = 0.1
"""Speed above which a joint counts as moving [rad/s]: three steps of 1.5 mrad in the window, the coarsest
encoder of a serial servo; slower than that, a way is seen."""
FAR = 0.1
"""Way that no load, spring or swing explains [rad]: six degrees."""
FURTHER = 0.2
"""Way that no arm on soft springs swings in which a quick stop has ended [rad]: twice that."""
FLANGE = 0.01
"""Way of the flange that counts as motion [m], in one direction and after the arm should have come to rest:
what a person who holds on to it notices, and more than what a position loop still settles then."""
TWICE = 2.0
"""Of the tracking limit, while a brake may still make an error smaller [-]."""
LIMP = 0.05
"""Share of the largest torque below which a drive does not drive [-]: what friction alone takes."""
FEWEST = 3
"""Samples at least that show a sign, however long they are apart."""


class Signs:
    """Looks at every cycle.

    Args:
        joints: Names.
        limits: Limits of the robot, finite in velocity and acceleration.
        current: Largest current, shape (n,) [A]; infinite where unknown.
        watch: What is in order.
        cycle: Time between samples [s].
        unit_of: Unit of a joint.
        tracking: What the watch of the run sees of the tracking error; else it is computed here.
        flange: Where the flange is, shape (3,) [m], at a position (n,); None where that is not known.
    """

    def __init__(
        self,
        joints: Sequence[str],
        limits: Limits,
        current: np.ndarray,
        watch: WatchLimits,
        cycle: float,
        unit_of: UnitOf = turning,
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
        self._seen = deque[tuple[float, np.ndarray]](maxlen=self._window + 1)
        self._commanded = deque[np.ndarray](maxlen=memory + self._window)
        self._drift = Drift(n, cycle, flange)
        self._unknown = np.full(n, np.nan)
        self._velocity = self._error = self._first = self._rest = self._before = self._unknown
        self._last_command: Command | None = None
        self._nowhere = self._way = np.zeros(n)
        self._stood: np.ndarray | None = None
        self._place: np.ndarray | None = None
        self._state, self._entered = State.LISTENING, 0.0
        self._since = {sign: _Lasting(n) for sign in WATCHED[self._state]}
        self._limits = {
            Sign.ADRIFT: np.full(n, FAR),
            Sign.BEHIND: np.full(n, TWICE * watch.tracking),
            Sign.AWAY: np.full(n, watch.tracking),
            Sign.OUTWARD: np.full(n, watch.outside),
            Sign.GOES_ON: np.full(n, FURTHER),
            Sign.CREEPS: np.full(n, FAR),
            Sign.FLANGE_CREEPS: np.full(n, FLANGE),
        }
        self._measures: dict[Sign, Callable[[Sample], np.ndarray]] = {
            Sign.ADRIFT: lambda sample: np.abs(sample.position - self._first),
            Sign.FASTER: self._faster,
            Sign.BEHIND: lambda sample: self._error,
            Sign.AWAY: lambda sample: self._error,
            Sign.OUTWARD: self._outward,
            Sign.GOES_ON: self._goes_on,
            Sign.CREEPS: lambda sample: self._way,
            Sign.FLANGE_CREEPS: self._flange_creeps,
        }

    def look(self, sample: Sample, sent: Command | None, state: State) -> dict[Sign, Sight]:
        """The signs of a state that are seen in this cycle, in which a command was sent."""
        time = 1e-9 * sample.host_time
        self._measure(sample, sent, time)
        if state is not self._state:
            self._enter(state, time)
        signs = WATCHED[state]
        if not signs:
            return {}
        self._settle(state, time)
        self._creep(sample)
        seen = {sign: self._seen_for(sign, sample, time) for sign in signs}
        return {sign: sight for sign, sight in seen.items() if sight is not None}

    @property
    def calm(self) -> bool:
        """Whether no joint is seen to move and no sign is seen, be it for how short."""
        if len(self._seen) <= self._window or np.any(np.abs(self._velocity) > MOVING):
            return False
        if any(lasting.count.any() for lasting in self._since.values()):
            return False
        return bool(np.all(np.abs(self._drift.speed()) <= RESTING))  # not while it is unknown

    def at_end(self) -> Standstill:
        """Whether the arm stands, by the last samples."""
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
        """Say whether an arm that stands does so where it was commanded last, but for the way of a stop."""
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
            f"the arm stands, and {name} {away[joint]:.3g} {unit} from where it was commanded last, limit "
            f"{limit[joint]:.3g}: it went there after that command, did not follow it, or its position is "
            "wrong. Look at the arm before the next run"
        )
        return Standstill(False, text, name, away=float(away[joint]))

    def _enter(self, state: State, time: float) -> None:
        """Begin with the signs of another state."""
        if state is State.QUICK:
            known = np.abs(self._velocity)
            self._before = np.where(np.isnan(known), self._fastest, known)
        self._state, self._entered, self._stood = state, time, None
        self._since = {sign: self._since.get(sign) or _Lasting(len(self._joints)) for sign in WATCHED[state]}

    def _settle(self, state: State, time: float) -> None:
        """Remember where the arm stands once it should stand."""
        since = time - self._entered - SETTLED
        if self._stood is None and since > 0.0:
            if state is not State.QUICK or overdue(self._before, self._deceleration, since).all():
                self._stood = self._drift.mean()

    def _seen_for(self, sign: Sign, sample: Sample, time: float) -> Sight | None:
        value = self._measures[sign](sample)
        limit = self._limits[sign]
        lasting = self._since[sign]
        seconds = lasting.add(time, value, limit)
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
        self._seen.append((time, position))
        self._velocity = self._unknown
        if len(self._seen) > self._window:
            before, stood = self._seen[0]
            self._velocity = (position - stood) / max(time - before, self._least)
        self._error = self._tracking.of(sample, sent)
        if sent is not None:
            self._last_command = sent
            self._commanded.append(np.abs(sent.velocity))
        if self._state is State.LISTENING:
            self._first = np.where(np.isnan(self._first), position, self._first)
            # An arm may begin outside, and come back in.
            self._lower, self._upper = np.fmin(self._lower, position), np.fmax(self._upper, position)

    def _faster(self, sample: Sample) -> np.ndarray:
        """Speed of a joint that is not where it was commanded, beside what was commanded at most lately.

        A soft arm that swings around where it is held is where it was commanded.
        """
        commanded = np.max(self._commanded, axis=0) if self._commanded else np.zeros(len(self._joints))
        self._limits[Sign.FASTER] = MOVING + self._watch.speed * commanded
        unknown = 0.0 * self._error  # NaN where unknown
        speed: np.ndarray = np.where(self._error > self._watch.tracking, np.abs(self._velocity), unknown)
        return speed

    def _outward(self, sample: Sample) -> np.ndarray:
        """How far beyond its limits a joint is that moves away from them."""
        below, above = self._lower - sample.position, sample.position - self._upper
        beyond = np.where(self._velocity < -MOVING, below, np.where(self._velocity > MOVING, above, 0.0))
        return np.asarray(beyond + 0.0 * self._velocity)

    def _goes_on(self, sample: Sample) -> np.ndarray:
        """Way since a quick stop should have ended, of a joint that is not slowing down as it should."""
        since, speed = self._seen[-1][0] - self._entered, np.abs(self._velocity)
        if not overdue(np.zeros(1), np.ones(1), since)[0]:  # the drives may not have reacted yet
            self._before = np.fmax(self._before, speed)
        due = overdue(self._before, self._deceleration, since)
        self._rest = np.where(due & np.isnan(self._rest), sample.position, self._rest)
        way = np.where(due, np.abs(sample.position - self._rest), 0.0)
        left = allowed_speed(self._before, self._deceleration, since) + MOVING
        driven = (speed > left) & ~self._limp(sample)
        return np.where(np.isnan(speed), np.nan, np.where(driven, way, 0.0))

    def _creep(self, sample: Sample) -> None:
        """Find the way of joints that go on in one direction since they should have come to rest."""
        self._way, self._place = self._nowhere, self._stood
        if self._stood is None:
            return
        creeping = self._drift.directed() & ~self._limp(sample)
        if any_of(creeping):
            self._place = np.where(creeping, self._drift.mean(), self._stood)
            self._way = np.nan_to_num(np.abs(self._place - self._stood))

    def _flange_creeps(self, sample: Sample) -> np.ndarray:
        """Way of the flange since the arm should have come to rest, of the joint that has gone furthest."""
        if self._way is self._nowhere or self._stood is None or self._place is None:
            return self._nowhere
        value = np.zeros(len(self._joints))
        value[int(np.argmax(self._way))] = self._drift.flange_way(self._stood, self._place)
        return value

    def _limp(self, sample: Sample) -> np.ndarray:
        """Joints that move by their weight, shape (n,): a drive has stopped itself, and these have no torque.

        To take the torque away would not stop them, and would let the others drop too.
        """
        if not sample.fault:
            return np.zeros(len(self._joints), bool)
        by_current = np.isfinite(self._current) & (np.abs(sample.current) < LIMP * self._current)
        by_torque = np.isfinite(self._torque) & (np.abs(sample.torque) < LIMP * self._torque)
        return by_current | by_torque


class _Lasting:
    """For how long each joint has been beyond a limit; a cycle that shows nothing of it is no break."""

    def __init__(self, joints: int) -> None:
        self.count = np.zeros(joints, int)
        self._began = np.zeros(joints)
        self._counting = False

    def add(self, time: float, value: np.ndarray, limit: np.ndarray) -> np.ndarray | None:
        """Seconds, shape (n,); -1 where it is not, or in fewer samples than count; None for no joint."""
        beyond = value > limit
        if not self._counting and not any_of(beyond):
            return None
        known = ~np.isnan(value)
        self._began = np.where(beyond & (self.count == 0), time, self._began)
        self.count = np.where(beyond, self.count + 1, np.where(known, 0, self.count))
        self._counting = bool(self.count.any())
        return np.where(self.count >= FEWEST, time - self._began, -1.0)
