"""What all drivers of servos on a serial line have in common: the cycle, the stops, the ways in and out.

In a cycle one packet sets all goals and one asks for all measurements, in a single write.
"""

import time
from abc import abstractmethod
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, ClassVar

import numpy as np

from ..driver import Arm, Driver, Info, StopLevel
from ..errors import BadSettings, DriverError, LinkLost, NotReady
from ..host_clock import HostClock, Pause, host_time, require_patience
from ..resting import COUNT, Resting
from ..samples import HostSamples
from ..values import Command, Sample
from .serial_port import SerialPort, adapter_latency, latency_warnings
from .servo_bus import ServoBus, ServoTalk
from .servo_line import (
    RETURN_DELAY_UNIT,
    Codec,
    Reading,
    Register,
    Status,
    Traffic,
    require_rate,
    shortest_cycle,
)
from .servo_units import Goals, Measured, ServoUnits, explained

BEFORE_RUN = 0.1
"""How long an answer is waited for before the run [s]."""

SETTLING, LOOK = 1.0, 0.05
"""How long servos may give way after their torque is switched on, and how often that is looked at [s]."""

IN_RUN, LONGER = 3.0, 0.005
"""How long one is waited for in the run [cycles], and at most longer than a cycle [s]: a late answer is
better than none, but the loop must come round."""


FEWEST = 2
"""Cycles that servos must wait for this computer at least."""


class ServoDriver(Driver):
    """Servos on a serial line, one a joint."""

    codec: ClassVar[Codec]
    baudrates: ClassVar[Sequence[int]]
    joining: ClassVar[str] = ""
    """What servos could do that join their answers to one packet, behind other advice."""
    _joined = False
    torque: ClassVar[Register]
    goal: ClassVar[Register]
    present: ClassVar[Register]
    return_delay: ClassVar[Register]
    lock: ClassVar[Register | None] = None
    """What keeps servos from a return delay that stays; None where nothing does."""

    def __init__(self, settings: Any, arm: Arm) -> None:
        super().__init__(settings, arm)
        twice = [one for one in settings.ids if settings.ids.count(one) > 1]
        if twice:
            raise BadSettings(f"two joints have the servo {twice[0]}. Try ids = one a joint, in their order")
        self._names = {
            servo: f"servo {servo} ({joint})" for servo, joint in zip(settings.ids, arm.joints, strict=True)
        }
        self._units = ServoUnits(settings)
        self._bus: ServoBus | None = None
        self._port: SerialPort | None = None
        self._armed = False
        self._samples = HostSamples(arm.dof)
        self._allowed = Goals(self._samples.unknown, self._samples.unknown)
        self._count, self._once = 0, b""
        self._held: np.ndarray | None = None
        self._stopped, self._goal_packet, self._fault = StopLevel.BRAKE, b"", ""
        self._pause = Pause(self.patience)
        self.latency = 0.0
        self._require_rate()
        require_patience("watchdog", self.patience, settings.cycle, FEWEST)

    @property
    def patience(self) -> float:
        """Silence of this computer after which servos stop by themselves [s]; infinite where they do not."""
        return float("inf")

    def open(self) -> Info:
        """Open the port, find the servos and set them up; torque is left as it is."""
        self._port = SerialPort(self.settings.port, self.settings.baudrate, BEFORE_RUN)
        self._bus = ServoBus(self._port, self.codec, self._names)
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
        """Make its goal where each servo stands, then switch its torque on; one that is on keeps its goal.

        Without an integrator a servo holds by what is left to its goal. Where it stands as the new goal, it
        would give way by as much.
        """
        bus, port = self._opened()
        port.be_patient(BEFORE_RUN)
        bus.drain()
        holding = np.array(bus.read(self.torque), bool)
        goals = np.where(holding, self._agreed(bus, self.goal), self._agreed(bus, self.present))
        bus.settle(self.goal, self._to_register(goals))
        bus.settle(self.torque, [1] * self.arm.dof)
        self._armed = True
        once = self._guard(bus)
        self._settle(bus)
        self._begin()
        self._once, self._held = once, self._units.position(goals)

    def _agreed(self, bus: ServoBus, register: Register) -> np.ndarray:
        """Counts in a register with a position, shape (n,), on which several readings agree.

        Raises NotReady where they do not: one that is wrong would be where the servo goes.
        """
        resting = Resting(self.arm.dof)
        for _ in range(COUNT):
            for joint, position in enumerate(self._units.position(self._read(bus, register)).tolist()):
                resting.add(joint, position)
        unsure = [joint for joint in range(self.arm.dof) if not resting.known(joint)]
        if unsure:
            raise NotReady(
                f"{bus.names[bus.servos[unsure[0]]]} is not switched on: by its {register}, "
                f"{resting.doubt(unsure[0])}. Let the arm stand still, and look at the cable"
            )
        return self._units.counts(np.array([resting.position(joint) for joint in range(self.arm.dof)]))

    def _settle(self, bus: ServoBus) -> None:
        """Wait until the servos' torque has met their load."""
        seen = self._read(bus, self.present)
        for _ in range(round(SETTLING / LOOK)):
            time.sleep(LOOK)
            before, seen = seen, self._read(bus, self.present)
            if np.all(np.abs(seen - before) <= 1.0):
                break

    def held(self) -> np.ndarray | None:
        return self._held

    def exchange(self, command: Command | None) -> Sample:
        """Send the goals and ask for all measurements, in one write."""
        bus, _ = self._opened()
        tick, events, before = self._clock.wait(), list[str](), self._goal_packet
        packets, self._once = self._once + self._goals_now(bus, command), b""
        readings = self._readings(self._count)
        length = readings[0].length
        if not self._count:  # with the first cycle servos are told anew to wait for this computer
            self._pause.begin()
        self._count += 1
        paused = self._pause.noticed() and self._armed
        if paused:
            packets, self._goal_packet = b"", before
            self._fault = self._fault or self._pause.text()
        answers = self._talk.exchange(packets, readings, events)
        now = host_time()
        measured, units = self._decode(_joined(answers, length), length), self._units
        answered = [answer is not None for answer in answers]
        self._fault = self._fault or self._look(answers, now, events)
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
        """Servos are asked, and torque and goals left as they are."""
        return "questions, and the set-up of a run; no goal, and torque is left as it is"

    def states(self) -> tuple[str, ...]:
        bus, port = self._opened()
        port.be_patient(BEFORE_RUN)
        try:
            found = bus.peek(self.torque)
        finally:
            port.be_patient(self._in_run)
        return tuple("" if on is None else f"torque {'on' if on else 'off'}" for on in found)

    def stop(self, level: StopLevel) -> None:
        """QUICK holds the goals that were last sent, OFF switches torque off; repeated every cycle after.

        Where a servo was last seen is no goal: a wrong measurement would set it in motion.
        """
        if self._bus is None or not self._armed or level <= self._stopped:
            return
        if level == StopLevel.OFF:
            self._goal_packet = self._bus.packet(self.torque, [0] * self.arm.dof)
        self._stopped = level
        with suppress(DriverError):
            self._bus.send_only(self._goal_packet)

    def close(self) -> None:
        """Leave the servos at their last goal, or off by the settings, and let go."""
        bus, port, self._bus, self._port = self._bus, self._port, None, None
        with suppress(DriverError):
            if bus is not None and self._armed:
                if self.settings.at_end == "off":
                    bus.send_only(bus.packet(self.torque, [0] * self.arm.dof))
                self._unguard(bus)
        self._armed = False
        if port is not None:
            port.close()

    def _opened(self) -> tuple[ServoBus, SerialPort]:
        if self._bus is None or self._port is None:
            raise LinkLost("the driver is not open. Open it first")
        return self._bus, self._port

    @property
    def _in_run(self) -> float:
        """How long an answer is waited for in a run [s]."""
        cycle: float = self.settings.cycle
        return min(IN_RUN * cycle, cycle + LONGER)

    def _begin(self) -> None:
        """Start the cycles."""
        bus, port = self._opened()
        port.be_patient(self._in_run)
        self._clock = HostClock(self.settings.cycle)
        self._talk = ServoTalk(bus)
        self._limits = [end.tolist() for end in self._allowed]
        self._count, self._once = 0, b""
        self._stopped, self._goal_packet, self._fault = StopLevel.BRAKE, b"", ""

    def _set_return_delay(self, bus: ServoBus) -> None:
        """Set it where it is another: servos keep it for good, and take it only while torque is off."""
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
            bus.settle(self.lock, [0] * self.arm.dof)
        bus.settle(register, wanted, pause=0.02)
        if self.lock:
            bus.settle(self.lock, [1] * self.arm.dof)

    def _read(self, bus: ServoBus, register: Register) -> np.ndarray:
        """Counts in a register with a position, shape (n,)."""
        return self._from_register(np.array(bus.read(register)))

    def _goals_now(self, bus: ServoBus, command: Command | None) -> bytes:
        """Goals of a stop or of the command; one that no servo takes is not sent and is a fault."""
        if self._stopped > StopLevel.BRAKE:
            return self._goal_packet
        if command is None or self._fault:
            return b""
        counts = self._units.counts(command.position)
        lowest, highest = self._limits
        inside = [
            low <= count <= high for low, count, high in zip(lowest, counts.tolist(), highest, strict=True)
        ]
        if all(inside):  # not so for what is no number
            self._goal_packet = bus.packet(self.goal, self._to_register(counts))
            return self._goal_packet
        joint = inside.index(False)
        self._fault = self._fault or (
            f"a command was not sent: {self.arm.joints[joint]} at {command.position[joint]:g} rad is count "
            f"{counts[joint]:g} of its servo, which takes {lowest[joint]:g} to {highest[joint]:g}"
        )
        return b""

    def _window(self, bus: ServoBus) -> tuple[np.ndarray, np.ndarray]:
        """How far the servos let the joints go from where they stand, two of shape (n,) [rad]."""
        ends = [self._units.way(end - self._read(bus, self.present)) for end in self._allowed]
        return np.minimum(*ends), np.maximum(*ends)

    def _info(
        self, bus: ServoBus, signals: Sequence[str], warnings: Sequence[str], dead_man: str, **facts: str
    ) -> Info:
        """Metadata of the driver once it is set up; `facts` explain the measurements later."""
        lower, upper = self._window(bus)
        latency = f"{1e3 * self.latency:g} ms"
        return Info(
            cycle=self.settings.cycle,
            clock="host",
            signals=tuple(signals),
            dead_man=dead_man,
            window_lower=lower,
            window_upper=upper,
            settings=explained(self.settings) | {"adapter_latency": latency} | facts,
            warnings=(*warnings, *latency_warnings(self.settings.port, self.latency)),
        )

    def _require_rate(self) -> None:
        """Nothing, if a cycle fits on the line as far as it is known."""
        s, traffic = self.settings, self._traffic(self._question())
        enough = [rate for rate in self.baudrates if self._shortest_cycle(traffic, rate) <= s.cycle]
        advice = f"a baudrate of {enough[0]}" if enough else "fewer servos on a port"
        advice += "" if self._joined else self.joining
        require_rate(traffic, s.cycle, s.baudrate, s.return_delay, self.latency, advice)

    def _shortest_cycle(self, traffic: Traffic, baudrate: int) -> float:
        return shortest_cycle(traffic, baudrate, self.settings.return_delay, self.latency)

    def _traffic(self, question: Reading) -> Traffic:
        """Bytes of a cycle with this question."""
        goals = self.codec.sync_write(self.goal.address, dict.fromkeys(self._names, bytes(self.goal.size)))
        delays = 1 if self._joined else self.arm.dof
        return Traffic(len(goals) + len(question.packet), question.answer_bytes, delays)

    @abstractmethod
    def _set_up(self, bus: ServoBus) -> Info:
        """Find the servos, set them up and verify it; sets `_allowed` on the way."""

    @abstractmethod
    def _question(self) -> Reading:
        """What is asked in most cycles."""

    @abstractmethod
    def _readings(self, number: int) -> Sequence[Reading]:
        """What to ask in a cycle, as `ServoTalk.exchange` takes it."""

    @abstractmethod
    def _decode(self, data: bytes, length: int) -> Measured:
        """Numbers out of the answers of all servos, of this length each, one behind the other."""

    @abstractmethod
    def _look(self, answers: Sequence[Status | None], now: int, events: list[str]) -> str:
        """Why servos have stopped themselves, by their error bytes and the time; empty if none has."""

    @abstractmethod
    def _to_register(self, counts: np.ndarray) -> list[int]:
        """Counts as the servo keeps them."""

    @abstractmethod
    def _from_register(self, numbers: np.ndarray) -> np.ndarray:
        """Counts out of what the servo keeps."""

    def _guard(self, bus: ServoBus) -> bytes:
        """Have the servos stop when the computer falls silent; what is to be sent with the first cycle."""
        return b""

    def _unguard(self, bus: ServoBus) -> None:  # noqa: B027 - likewise
        """Have them go on holding when it does."""


def _joined(answers: Sequence[Status | None], length: int) -> bytes:
    """The data of all servos one behind the other, zeros for those that are missing."""
    return b"".join(bytes(length) if answer is None else answer.data for answer in answers)
