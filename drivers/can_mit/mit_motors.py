"""The cyclic part of motors with the MIT frame: to each a command, which is the question, and its answer."""

import time
from enum import Enum

from ..can.can_bus import CanBus
from ..can.can_driver import CanRound
from ..can.transports import Frame
from ..host_clock import host_time
from . import mit_frame as mit
from .damiao import TO_ALL, refresh
from .mit_frame import DAMIAO, Family, Motor, State, answering, error_text


class Request(Enum):
    """What a motor is sent in a cycle; it answers to all of it."""

    LISTEN = "send your state"
    LIMP = "zero gains"
    CLEAR = "clear your error"
    ENABLE = "switch on"
    COMMAND = "follow"
    DISABLE = "switch off"


UNKNOWN = State(0, *[float("nan")] * 4)
"""Before the first answer."""


class MotorRound(CanRound):
    """Commands to the motors and their answers, at their outputs and with their signs.

    Attributes:
        request: What each is sent from now on.
        state: Last answer of each.
        target: Commanded position of each [rad].
        velocity: Commanded velocity of each [rad/s].
        watching: Whether an error is a fault.
    """

    def __init__(self, bus: CanBus, motors: list[Motor]) -> None:
        super().__init__(bus, [motor.name for motor in motors])
        self._motors = motors
        count = len(motors)
        self.request, self.state = [Request.LISTEN] * count, [UNKNOWN] * count
        self.target, self.velocity = [0.0] * count, [0.0] * count
        self.watching = False
        self._constant = [_constant_frames(motor) for motor in motors]
        self._gains = [mit.gains(motor.commanded, motor.kp, motor.kd) for motor in motors]
        self._answers: dict[Family, dict[tuple[int, int], int]] = {}
        for joint, m in enumerate(motors):
            answers = self._answers.setdefault(m.family, {})
            answers[m.master, answering(m.family, bytes([m.number & 0xFF]))] = joint

    def cycle(self, patience: float) -> int:
        """A motor measures when it is reached by its question."""
        self._read_late()
        now = host_time()
        self._bus.send_frames(
            [
                self._command(joint) if request is Request.COMMAND else self._constant[joint][request]
                for joint, request in enumerate(self.request)
            ]
        )
        self._collect(time.monotonic() + patience)
        return now

    def _command(self, joint: int) -> Frame:
        motor = self._motors[joint]
        motion = self.target[joint], self.velocity[joint]
        return motor.number, mit.with_motion(motor.commanded, *motion, self._gains[joint])

    def _understand(self, identifier: int, data: bytes) -> bool:
        for family, answers in self._answers.items():
            joint = answers.get((identifier, answering(family, data))) if data else None
            if joint is not None:
                state = mit.unpack(self._motors[joint].answered, family, data)
                if state is not None:
                    self._take(joint, state)
                    return True
        return False

    def _take(self, joint: int, state: State) -> None:
        before, self.state[joint] = self.state[joint], state
        self._answered(joint)
        family = self._motors[joint].family
        if state.error == before.error:
            return
        text = error_text(family, state.error)
        if text and self.watching:
            self.fail(f"{self._names[joint]}: {text}")
        elif (
            self.watching and family is DAMIAO and state.error == 0 and self.request[joint] is Request.COMMAND
        ):
            self.fail(f"{self._names[joint]}: has switched itself off")
        else:
            self.report(f"{self._names[joint]}: {text or ('on' if state.error else 'off or no error')}")


def _constant_frames(motor: Motor) -> dict[Request, Frame]:
    limp = motor.number, mit.pack(motor.commanded, 0.0, 0.0, 0.0, 0.0)
    listen = (TO_ALL, refresh(motor.number)) if motor.family.registers else limp
    fixed = {Request.CLEAR: mit.CLEAR, Request.ENABLE: mit.ENABLE, Request.DISABLE: mit.DISABLE}
    return {
        Request.LISTEN: listen,
        Request.LIMP: limp,
        **{request: (motor.number, data) for request, data in fixed.items()},
    }
