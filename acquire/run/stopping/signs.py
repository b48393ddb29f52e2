"""Signs: what the arm does, held against what a stop should make it do by then."""

from collections import deque
from collections.abc import Sequence

import numpy as np

from exidyn.drivers import Command, Sample
from exidyn.identify.arm.robot import Limits

from .escalation import UNITS, Sight, Sign, State, allowed_speed, overdue, watched
from .monitors import Tracking
from .stop import UnitOf, turning
from .watch import WatchLimits

WINDOW = 0.05
"""Time over which a speed is a mean [s]."""
MOVING = 0.1
"""Speed above which a joint counts as moving [rad/s]: three steps of 1.5 mrad in the window, the coarsest
encoder of a serial servo; slower than that, an error of position is seen."""
FAR = 0.1
"""Way that no load, spring or swing explains [rad]: six degrees."""
FURTHER = 0.2
"""Way that no arm on soft springs swings in which a quick stop has ended [rad]: twice that."""
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
        limits: Of the robot, finite in velocity and acceleration.
        current: Largest current, shape (n,) [A]; infinite where unknown.
        watch: What is in order.
        cycle: Time between samples [s].
        unit_of: Unit of a joint.
    """

    def __init__(
        self,
        joints: Sequence[str],
        limits: Limits,
        current: np.ndarray,
        watch: WatchLimits,
        cycle: float,
        unit_of: UnitOf = turning,
    ) -> None:
        n = len(joints)
        self._joints, self._watch, self._current = joints, watch, current
        self._unit_of = unit_of
        self._torque = limits.torque
        self._lower, self._upper = limits.position_lower, limits.position_upper
        self._deceleration = np.minimum(limits.acceleration, -limits.acceleration_lower)
        self._fastest = np.maximum(limits.velocity, -limits.velocity_lower)
        memory = max(round(watch.delay / cycle), 1)
        self._tracking = Tracking(joints, np.full(n, watch.tracking), 1, memory)
        self._window = max(round(WINDOW / cycle), 2)
        self._least = self._window * cycle
        self._seen = deque[tuple[float, np.ndarray]](maxlen=self._window + 1)
        self._commanded = deque[np.ndarray](maxlen=memory + self._window)
        self._unknown = np.full(n, np.nan)
        self._velocity = self._error = self._first = self._rest = self._before = self._unknown
        self._since = dict[Sign, _Lasting]()
        self._state = State.LISTENING
        self._quick = 0.0
        self._measures = {
            Sign.ADRIFT: self._adrift,
            Sign.FASTER: self._faster,
            Sign.BEHIND: lambda sample: (self._error, np.full(n, TWICE * watch.tracking)),
            Sign.AWAY: lambda sample: (self._error, np.full(n, watch.tracking)),
            Sign.OUTWARD: self._outward,
            Sign.GOES_ON: self._goes_on,
        }

    def look(self, sample: Sample, sent: Command | None, state: State) -> dict[Sign, Sight]:
        """The signs of a state that are seen in this cycle, in which a command was sent."""
        time = 1e-9 * sample.controller_time
        self._measure(sample, sent, time)
        if state is State.QUICK and self._state is not state:
            known = np.abs(self._velocity)
            self._quick, self._before = time, np.where(np.isnan(known), self._fastest, known)
        self._state = state
        self._since = {sign: self._since.get(sign) or _Lasting(len(self._joints)) for sign in watched(state)}
        seen = {sign: self._seen_for(sign, sample, time) for sign in self._since}
        return {sign: sight for sign, sight in seen.items() if sight is not None}

    @property
    def calm(self) -> bool:
        """Whether no joint is seen to move and no sign is seen, be it for how short."""
        still = len(self._seen) > self._window and not np.any(np.abs(self._velocity) > MOVING)
        return still and not any(lasting.count.any() for lasting in self._since.values())

    def _seen_for(self, sign: Sign, sample: Sample, time: float) -> Sight | None:
        value, limit = self._measures[sign](sample)
        lasting = self._since[sign]
        seconds = lasting.add(time, value, limit)
        j = int(np.argmax(seconds))
        if seconds[j] < 0.0 or np.isnan(value[j]):
            return None
        unit = self._unit_of(j, UNITS.get(sign, "rad"))
        return Sight(self._joints[j], float(value[j]), float(limit[j]), float(seconds[j]), unit)

    def _measure(self, sample: Sample, sent: Command | None, time: float) -> None:
        position = sample.position
        self._seen.append((time, position))
        self._velocity = self._unknown
        if len(self._seen) > self._window:
            before, stood = self._seen[0]
            self._velocity = (position - stood) / max(time - before, self._least)
        self._first = np.where(np.isnan(self._first), position, self._first)
        self._error = self._tracking.value(sample, sent)
        if sent is not None:
            self._commanded.append(np.abs(sent.velocity))
        if self._state is State.LISTENING:  # an arm may begin outside, and come back in
            self._lower, self._upper = np.fmin(self._lower, position), np.fmax(self._upper, position)

    def _adrift(self, sample: Sample) -> tuple[np.ndarray, np.ndarray]:
        """Way from where the joint stood at first, while it moves; NaN where unknown."""
        way, speed = np.abs(sample.position - self._first), np.abs(self._velocity)
        moving = np.where(speed > MOVING, way, 0.0)
        return np.where(np.isnan(speed), np.nan, moving), np.full(len(self._joints), FAR)

    def _faster(self, sample: Sample) -> tuple[np.ndarray, np.ndarray]:
        """Speed of a joint that is not where it was commanded, and what was commanded at most lately.

        A soft arm that swings around where it is held is where it was commanded.
        """
        commanded = np.max(self._commanded, axis=0) if self._commanded else np.zeros(len(self._joints))
        unknown = 0.0 * self._error  # NaN where unknown
        speed = np.where(self._error > self._watch.tracking, np.abs(self._velocity), unknown)
        return speed, MOVING + self._watch.speed * commanded

    def _outward(self, sample: Sample) -> tuple[np.ndarray, np.ndarray]:
        """How far beyond its limits a joint is that moves away from them."""
        below, above = self._lower - sample.position, sample.position - self._upper
        beyond = np.where(self._velocity < -MOVING, below, np.where(self._velocity > MOVING, above, 0.0))
        return beyond + 0.0 * self._velocity, np.full(len(self._joints), self._watch.tracking)

    def _goes_on(self, sample: Sample) -> tuple[np.ndarray, np.ndarray]:
        """Way since a quick stop should have ended, of a joint that is not slowing down as it should."""
        since, speed = self._seen[-1][0] - self._quick, np.abs(self._velocity)
        if not overdue(np.zeros(1), np.ones(1), since)[0]:  # the drives may not have reacted yet
            self._before = np.fmax(self._before, speed)
        due = overdue(self._before, self._deceleration, since)
        self._rest = np.where(due & np.isnan(self._rest), sample.position, self._rest)
        way = np.where(due, np.abs(sample.position - self._rest), 0.0)
        left = allowed_speed(self._before, self._deceleration, since) + MOVING
        driven = (speed > left) & ~self._limp(sample)
        return np.where(np.isnan(speed), np.nan, np.where(driven, way, 0.0)), np.full(len(way), FURTHER)

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
    """For how long each joint has been beyond a limit; a cycle that shows nothing of it is no break.

    Args:
        joints: How many.
    """

    def __init__(self, joints: int) -> None:
        self.count = np.zeros(joints, int)
        self._began = np.zeros(joints)

    def add(self, time: float, value: np.ndarray, limit: np.ndarray) -> np.ndarray:
        """Seconds, shape (n,); -1 where it is not, or in fewer samples than count."""
        beyond, known = value > limit, ~np.isnan(value)
        self._began = np.where(beyond & (self.count == 0), time, self._began)
        self.count = np.where(beyond, self.count + 1, np.where(known, 0, self.count))
        return np.where(self.count >= FEWEST, time - self._began, -1.0)
