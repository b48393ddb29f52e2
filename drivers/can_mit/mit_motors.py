"""Cyclic part of motors with the MIT frame: each motor answers its command."""

from enum import Enum

import numpy as np

from ..can.can_bus import CanBus
from ..can.can_driver import CanRound
from ..can.transports import Frame
from . import mit_frame as mit
from .damiao import TO_ALL, is_register, refresh
from .mit_frame import DAMIAO, Family, Motor, State, answering, error_text


class Request(Enum):
    """Request to a motor in a cycle; it answers every request."""

    LISTEN = "send your state"
    LIMP = "zero gains"
    CLEAR = "clear your error"
    ENABLE = "switch on"
    COMMAND = "follow"
    DISABLE = "switch off"


SATURATED = 1.0 - 1e-6
"""Fraction of its range from which on a position is the end of the scale, not a measurement [-]."""
UNKNOWN = State(0, *[float("nan")] * 4)
"""State before the first answer."""


class MotorRound(CanRound):
    """Commands to the motors and their answers, at the outputs of the motors and with their signs."""

    def __init__(self, bus: CanBus, motors: list[Motor]) -> None:
        super().__init__(bus, [motor.name for motor in motors], may_skip=True)
        self._motors = motors
        count = len(motors)
        self.request = [Request.LISTEN] * count  # request that each motor is sent from now on
        self.state = [UNKNOWN] * count  # last answer of each motor
        self.target, self.velocity = [0.0] * count, [0.0] * count  # commands to each motor [rad], [rad/s]
        self.watching = False  # whether an error is a fault
        self._constant = [_constant_frames(motor) for motor in motors]
        self._gains = [mit.gains(motor.commanded, motor.kp, motor.kd) for motor in motors]
        self._joints: dict[Family, dict[tuple[int, int], int]] = {}
        for joint, m in enumerate(motors):
            joints = self._joints.setdefault(m.family, {})
            joints[m.master, answering(m.family, bytes([m.number & 0xFF]))] = joint
        masters = {motor.master for motor in motors}
        self._commands = {motor.number: motor.name for motor in motors if motor.number not in masters}

    def cycle(self, patience: float) -> int:
        """Run a cycle as in `CanRound`; a motor measures when its request arrives."""
        to_ask = self._ask()
        now = self._clock.host_time()
        self._bus.send_frames(
            [
                self._command(joint) if request is Request.COMMAND else self._constant[joint][request]
                for joint, request in enumerate(self.request)
                if to_ask[joint]
            ]
        )
        self._collect(self._clock.monotonic() + patience)
        return now

    def _commanded_by(self, identifier: int) -> str:
        if identifier == TO_ALL:
            return "requests to Damiao motors"
        name = self._commands.get(identifier)
        return f"commands to {name}" if name else ""

    def _command(self, joint: int) -> Frame:
        motor = self._motors[joint]
        motion = self.target[joint], self.velocity[joint]
        return motor.number, mit.with_motion(motor.commanded, *motion, self._gains[joint])

    def _understand(self, identifier: int, data: bytes) -> bool:
        for family, answers in self._joints.items():
            joint = answers.get((identifier, answering(family, data))) if data else None
            if joint is None:
                continue
            motor = self._motors[joint]
            if family.registers and is_register(motor.number, data):
                return True
            state = mit.unpack(motor.answered, family, data)
            if state is not None:
                self._take(joint, state)
                return True
        return False

    def _take(self, joint: int, state: State) -> None:
        if abs(state.position) >= SATURATED * self._motors[joint].answered.position:
            state = self._without_position(joint, state)
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

    def _without_position(self, joint: int, state: State) -> State:
        """Remove a position at the end of the scale from a state."""
        if np.isfinite(self.state[joint].position) or self.state[joint] is UNKNOWN:
            self.report(
                f"{self._names[joint]}: its position of {state.position:.4g} rad is the end of its range; "
                "not used"
            )
        return state._replace(position=float("nan"))


def _constant_frames(motor: Motor) -> dict[Request, Frame]:
    limp = motor.number, mit.pack(motor.commanded, 0.0, 0.0, 0.0, 0.0)
    listen = (TO_ALL, refresh(motor.number)) if motor.family.registers else limp
    fixed = {Request.CLEAR: mit.CLEAR, Request.ENABLE: mit.ENABLE, Request.DISABLE: mit.DISABLE}
    return {
        Request.LISTEN: listen,
        Request.LIMP: limp,
        **{request: (motor.number, data) for request, data in fixed.items()},
    }
