"""Common part of drivers of servos on a serial line: opening, cycles, stops and closing.

In each cycle, one packet sets all goals and another asks for all measurements, in a single write.
"""

from abc import abstractmethod
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, ClassVar

import numpy as np

from ..driver import Arm, Driver, Info, StopLevel
from ..errors import BadSettings, DriverError, LinkLost, NotReady
from ..host_clock import HostClock, Pause, require_patience
from ..samples import HostSamples
from ..values import AGREEING, Command, Resting, Sample
from .serial_port import SerialPort, adapter_latency, latency_warnings
from .servo_bus import ServoBus, ServoTalk
from .servo_line import (
    RETURN_DELAY_UNIT,
    Codec,
    Goals,
    Measured,
    Reading,
    Register,
    ServoUnits,
    Status,
    Traffic,
)

BEFORE_RUN = 0.1
"""Maximum time to wait for an answer before the run [s]."""

SETTLING, LOOK = 1.0, 0.05
"""Maximum time for servos to settle after power-on, and time between the checks [s]."""

IN_RUN, LONGER = 3.0, 0.005
"""Maximum time to wait for an answer in the run [cycles], and its excess over one cycle [s]: a late answer is
better than none, but the loop must continue."""


FEWEST = 2
"""Minimum patience of servos [cycles]."""


class ServoDriver(Driver):
    """Servos on a serial line, one per joint."""

    codec: ClassVar[Codec]
    baudrates: ClassVar[Sequence[int]]
    joining: ClassVar[str] = ""
    """Advice about servos that join their answers to one packet, appended to other advice."""
    _joined = False
    torque: ClassVar[Register]
    goal: ClassVar[Register]
    present: ClassVar[Register]
    return_delay: ClassVar[Register]
    lock: ClassVar[Register | None] = None
    """Register that locks the permanent memory of the return delay; None without such a lock."""

    def __init__(self, settings: Any, arm: Arm) -> None:
        super().__init__(settings, arm)
        twice = [servo for servo in settings.ids if settings.ids.count(servo) > 1]
        if twice:
            raise BadSettings(f"two joints have the servo {twice[0]}. Give each joint its own id in ids")
        self._names = {
            servo: f"servo {servo} ({joint})" for servo, joint in zip(settings.ids, arm.joints, strict=True)
        }
        self._units = ServoUnits(settings)
        self._bus: ServoBus | None = None

        self._armed = False
        self._samples = HostSamples(arm.dof)
        self._allowed = Goals(self._samples.unknown, self._samples.unknown)
        self._count, self._once = 0, b""
        self._held: np.ndarray | None = None
        self._stopped, self._goal_packet, self._fault = StopLevel.BRAKE, b"", ""
        self._pause = Pause(self.patience, self.clock)
        self.latency = 0.0
        self._require_rate()
        require_patience("watchdog", self.patience, settings.cycle, FEWEST)

    @property
    def patience(self) -> float:
        """Silence of this computer after which servos stop by themselves [s]; infinite if they do not."""
        return float("inf")

    def open(self) -> Info:
        """Open the port, find the servos and set them up; torque is left as it is."""
        port = SerialPort(self.settings.port, self.settings.baudrate, BEFORE_RUN, self.clock)
        self._bus = ServoBus(port, self.codec, self._names)
        self.latency = adapter_latency(self.settings.port)
        try:
            info = self._set_up(self._bus)
            self._require_rate()
            self._begin()
        except BaseException:
            self.close()
            raise
        return info

    def arm_drives(self) -> None:
        """Set each servo's goal to its position and switch its torque on; a servo that is on keeps its goal.

        A servo without an integrator needs a position error to hold a load. With its position as the new
        goal, it would give way by this error.
        """
        bus = self._opened()
        bus.port.set_patience(BEFORE_RUN)
        bus.drain()
        holding = np.array(bus.read(self.torque), bool)
        goals = np.where(holding, self._confirmed(bus, self.goal), self._confirmed(bus, self.present))
        bus.set_checked(self.goal, list(map(int, goals.tolist())))
        bus.set_checked(self.torque, [1] * self.arm.dof)
        self._armed = True
        once = self._guard(bus)
        self._wait_until_settled(bus)
        self._begin()
        self._once, self._held = once, self._units.position(goals)

    def _confirmed(self, bus: ServoBus, register: Register) -> np.ndarray:
        """Read a position register until several readings agree, and return the counts, shape (n,).

        Raises NotReady if they do not agree: the servo would move to a wrong reading.
        """
        resting = Resting(self.arm.dof)
        for _ in range(AGREEING):
            for joint, position in enumerate(self._units.position(self._read(bus, register)).tolist()):
                resting.add(joint, position)
        unsure = [joint for joint in range(self.arm.dof) if not resting.known(joint)]
        if unsure:
            raise NotReady(
                f"{bus.names[bus.servos[unsure[0]]]} is not switched on: by its {register}, "
                f"{resting.doubt(unsure[0])}. Let the arm stand still, and look at the cable"
            )
        return self._units.counts(np.array([resting.position(joint) for joint in range(self.arm.dof)]))

    def _wait_until_settled(self, bus: ServoBus) -> None:
        """Wait until the servos' torque balances their load."""
        seen = self._read(bus, self.present)
        for _ in range(round(SETTLING / LOOK)):
            self.clock.sleep(LOOK)
            before, seen = seen, self._read(bus, self.present)
            if np.all(np.abs(seen - before) <= 1.0):
                break

    def held(self) -> np.ndarray | None:
        return self._held

    def exchange(self, command: Command | None) -> Sample:
        """Send the goals and ask for all measurements, in one write."""
        bus = self._opened()
        tick, events, before = self._clock.wait(), list[str](), self._goal_packet
        packets, self._once = self._once + self._goals_now(bus, command), b""
        readings = self._readings(self._count)
        length = readings[0].length
        if not self._count:  # the first cycle resets the servos' watchdog
            self._pause.begin()
        self._count += 1
        paused = self._pause.noticed() and self._armed
        if paused:
            packets, self._goal_packet = b"", before
            self._fault = self._fault or self._pause.text()
        answers = self._talk.exchange(packets, readings, events)
        now = self.clock.host_time()
        data = b"".join(bytes(length) if answer is None else answer.data for answer in answers)
        measured, units = self._decode(data, length), self._units
        answered = [answer is not None for answer in answers]
        self._fault = self._fault or self._find_fault(answers, now, events)
        return self._samples.of(
            now,
            tick,
            answered,
            position=units.position(measured.position),
            velocity=units.velocity(measured.velocity),
            current=measured.current * units.sign,
            temperature=measured.temperature,
            events=tuple(events),
            fault=self._fault,
            sent=command is None or not paused,
        )

    @property
    def sent_to_read(self) -> str:
        """Questions and the set-up; torque and goals stay as they are."""
        return "questions, and the set-up of a run; no goal, and torque is left as it is"

    def states(self) -> tuple[str, ...]:
        bus = self._opened()
        bus.port.set_patience(BEFORE_RUN)
        try:
            torques = bus.peek(self.torque)
        finally:
            bus.port.set_patience(self._in_run)
        return tuple("" if on is None else f"torque {'on' if on else 'off'}" for on in torques)

    def stop(self, level: StopLevel) -> None:
        """Stop the servos: QUICK holds the last goals, OFF switches torque off. Each cycle repeats the stop.

        The last measured position is not the goal: a wrong measurement would set the servo in motion.
        """
        if self._bus is None or not self._armed or level <= self._stopped:
            return
        if level == StopLevel.OFF:
            self._goal_packet = self._bus.packet(self.torque, [0] * self.arm.dof)
        self._stopped = level
        with suppress(DriverError):
            self._bus.send_only(self._goal_packet)

    def close(self) -> None:
        """Leave the servos at their last goal, or off if the settings say so, and close the port."""
        bus, self._bus = self._bus, None
        if bus is None:
            return
        with suppress(DriverError):
            if self._armed:
                if self.settings.at_end == "off":
                    bus.send_only(bus.packet(self.torque, [0] * self.arm.dof))
                self._unguard(bus)
        self._armed = False
        bus.port.close()

    def _opened(self) -> ServoBus:
        if self._bus is None:
            raise LinkLost("the driver is not open. Open it first")
        return self._bus

    @property
    def _in_run(self) -> float:
        """Maximum time to wait for an answer in a run [s]."""
        cycle: float = self.settings.cycle
        return min(IN_RUN * cycle, cycle + LONGER)

    def _begin(self) -> None:
        """Start the cycles."""
        bus = self._opened()
        bus.port.set_patience(self._in_run)
        self._clock = HostClock(self.settings.cycle, self.clock)
        self._talk = ServoTalk(bus)
        self._limits = [end.tolist() for end in self._allowed]
        self._count, self._once = 0, b""
        self._stopped, self._goal_packet, self._fault = StopLevel.BRAKE, b"", ""

    def _set_return_delay(self, bus: ServoBus) -> None:
        """Set the return delay if it differs: servos store it permanently, and only while torque is off."""
        register, seconds = self.return_delay, self.settings.return_delay
        wanted = [round(seconds / RETURN_DELAY_UNIT)] * self.arm.dof
        if bus.read(register) == wanted:
            return
        holding = [bus.names[s] for s, on in zip(bus.servos, bus.read(self.torque), strict=True) if on]
        if holding:
            raise NotReady(
                f"{register} can be set to {1e6 * seconds:g} us only while torque is off, and "
                f"{', '.join(holding)} has it on. Support the arm and switch its power off and on"
            )
        if self.lock:
            bus.set_checked(self.lock, [0] * self.arm.dof)
        bus.set_checked(register, wanted, pause=0.02)
        if self.lock:
            bus.set_checked(self.lock, [1] * self.arm.dof)

    def _read(self, bus: ServoBus, register: Register) -> np.ndarray:
        """Read a position register [counts], shape (n,)."""
        return np.array(bus.read(register), float)

    def _goals_now(self, bus: ServoBus, command: Command | None) -> bytes:
        """Packet with the goals of a stop or a command; a command outside the limits is a fault."""
        if self._stopped > StopLevel.BRAKE:
            return self._goal_packet
        if command is None or self._fault:
            return b""
        counts = self._units.counts(command.position)
        lowest, highest = self._limits
        inside = [
            low <= count <= high for low, count, high in zip(lowest, counts.tolist(), highest, strict=True)
        ]
        if all(inside):  # false for NaN
            self._goal_packet = bus.packet(self.goal, list(map(int, counts.tolist())))
            return self._goal_packet
        joint = inside.index(False)
        self._fault = self._fault or (
            f"a command was not sent: {self.arm.joints[joint]} at {command.position[joint]:g} rad is count "
            f"{counts[joint]:g} of its servo, which takes {lowest[joint]:g} to {highest[joint]:g}"
        )
        return b""

    def _info(
        self, bus: ServoBus, signals: Sequence[str], warnings: Sequence[str], dead_man: str, **facts: str
    ) -> Info:
        """Metadata of the driver once it is set up; `facts` explain the measurements later."""
        ends = [self._units.displacement(end - self._read(bus, self.present)) for end in self._allowed]
        explained = {
            name: " ".join(map(str, value)) if isinstance(value, tuple) else str(value)
            for name, value in vars(self.settings).items()
        }
        return Info(
            cycle=self.settings.cycle,
            clock="host",
            signals=tuple(signals),
            dead_man=dead_man,
            window_lower=np.minimum(*ends),
            window_upper=np.maximum(*ends),
            settings=explained | {"adapter_latency": f"{1e3 * self.latency:g} ms"} | facts,
            warnings=(*warnings, *latency_warnings(self.settings.port, self.latency)),
        )

    def _require_rate(self) -> None:
        """Raise BadSettings if the line cannot carry a cycle, as far as is known."""
        s, traffic = self.settings, self._traffic(self._question())
        enough = [rate for rate in self.baudrates if traffic.shortest_cycle(rate) <= s.cycle]
        advice = f"a baudrate of {enough[0]}" if enough else "fewer servos on a port"
        advice += "" if self._joined else self.joining
        traffic.require_rate(s.cycle, s.baudrate, advice)

    def _traffic(self, question: Reading) -> Traffic:
        """Traffic of a cycle with this question."""
        goals = self.codec.sync_write(self.goal.address, dict.fromkeys(self._names, bytes(self.goal.size)))
        delays = 1 if self._joined else self.arm.dof
        sent, return_delay = len(goals) + len(question.packet), self.settings.return_delay
        return Traffic(sent, question.answer_bytes, delays, return_delay, self.latency)

    @abstractmethod
    def _set_up(self, bus: ServoBus) -> Info:
        """Find the servos, set them up and verify it; sets `_allowed` on the way."""

    @abstractmethod
    def _question(self) -> Reading:
        """Question of most cycles."""

    @abstractmethod
    def _readings(self, number: int) -> Sequence[Reading]:
        """Readings of a cycle, for `ServoTalk.exchange`."""

    @abstractmethod
    def _decode(self, data: bytes, length: int) -> Measured:
        """Decode the concatenated answers of all servos, each of this length; zeros replace missing ones."""

    @abstractmethod
    def _find_fault(self, answers: Sequence[Status | None], now: int, events: list[str]) -> str:
        """Why servos have stopped themselves, from their error bytes and gaps; empty if none has."""

    def _guard(self, bus: ServoBus) -> bytes:
        """Make the servos stop when the computer falls silent; returns packets for the first cycle."""
        return b""

    def _unguard(self, bus: ServoBus) -> None:  # noqa: B027 - not all servos have a watchdog
        """Make the servos keep holding when the computer falls silent."""
