"""Motors with the MIT frame on a CAN bus: Damiao, and T-Motor's AK series in MIT mode.

A command is a spring to a position and a damper to a velocity: kp (position - measured) +
kd (velocity - measured). The deflection of the spring carries the load, so that the arm deviates from its
commands by load / kp. Each motor answers its command at once.
"""

import numpy as np

from ..can.can_driver import CanDriver
from ..driver import Arm, Info, StopLevel
from ..errors import LinkLost, NotReady
from ..values import Command, Resting
from .damiao import MotorData, leave, set_up
from .mit_frame import DAMIAO, ON, T_MOTOR, Family, error_text
from .mit_motors import UNKNOWN, MotorRound, Request
from .settings import MitSettings, info_of, require_sound

ENABLING = 2.0
"""Maximum time to switch the motors on [s]."""
LIMP = 3
"""Number of cycles with zero gains before a motor is switched on, which clear its old command."""
BLIND = 3
"""Number of cycles with the command to switch on, for a motor that does not report whether it is on."""
ANSWERS = 0.5
"""Maximum time to wait for the first answers [s]."""


class CanMit(CanDriver[MotorRound]):
    """Motors with the MIT frame."""

    Settings = MitSettings
    settings: MitSettings

    def __init__(self, settings: MitSettings, arm: Arm) -> None:
        super().__init__(settings, arm)
        require_sound(settings, arm)
        self._motors = settings.motors(arm.joints)
        self._sign, self._zero = np.array(settings.sign, float), np.array(settings.zero)
        self._to_torque, self._to_current = self._scales()
        self._motor_data: list[MotorData] = []
        self._attempts, self._resting = [0] * arm.dof, Resting(arm.dof)

    def open(self) -> Info:
        return self._open(self.settings.dead_man)

    def open_to_read(self) -> Info:
        """Open without a dead-man function, which would switch off motors that another program left on."""
        return self._open(None)

    @property
    def sent_to_read(self) -> str:
        questions = "questions for states and registers" if DAMIAO in self._families else ""
        limp = "commands with zero gains (T-Motor)" if T_MOTOR in self._families else ""
        return " and ".join(filter(None, (questions, limp)))

    @property
    def risk_of_reading(self) -> str:
        """Risk that T-Motor motors go limp, because they answer only to commands."""
        if T_MOTOR not in self._families:
            return ""
        names = [motor.name for motor in self._motors if motor.family is T_MOTOR]
        return (
            f"{', '.join(names)}: T-Motor sends its state only when commanded, here with zero gains. A motor "
            "that is off stays off; a motor left on by another program goes limp: an arm without brakes drops"
        )

    def states(self) -> tuple[str, ...]:
        """State of each motor; empty for a T-Motor without fault, which does not report whether it is on."""
        return tuple(
            error_text(motor.family, state.error)
            or (("on" if state.error == ON else "off") if motor.family is DAMIAO else "")
            if np.isfinite(state.position)
            else ""
            for motor, state in zip(self._motors, self._opened().state, strict=True)
        )

    @property
    def _host_patience(self) -> float:
        guarded = any(motor.family is DAMIAO for motor in self.settings.motors(self.arm.joints))
        return super()._host_patience if guarded else float("inf")

    @property
    def _families(self) -> set[Family]:
        return {motor.family for motor in self._motors}

    def _open(self, dead_man: float | None) -> Info:
        bus = self._open_bus()
        try:
            self._motor_data = [
                set_up(bus, motor, dead_man) if motor.family.registers else MotorData()
                for motor in self._motors
            ]
            self._round = MotorRound(bus, self._motors)
            self._read_all(self._round)
        except BaseException:
            self.close()
            raise
        scales = self._to_current, self._to_torque
        return info_of(self.settings, self._motors, self._motor_data, self._round.state, *scales)

    def arm_drives(self) -> None:
        """Switch on with zero gains, then hold each joint at its position."""
        talk = self._opened()
        self._begin_commands(talk)
        self._level, self._attempts, self._armed = 0, [0] * self.arm.dof, True
        self._resting = Resting(self.arm.dof)
        talk.watching = False
        talk.request = [
            request
            if request is Request.COMMAND and motor.family is T_MOTOR and not state.error
            else Request.LISTEN
            for request, motor, state in zip(talk.request, self._motors, talk.state, strict=True)
        ]
        end = self.clock.monotonic() + ENABLING
        while not all(request is Request.COMMAND for request in talk.request):
            if talk.fault or self.clock.monotonic() > end:
                why = talk.fault or self._not_enabled(talk)
                self.stop(StopLevel.OFF)
                raise NotReady(why)
            self._cycles(talk, 1)
            for joint in range(self.arm.dof):
                self._request_enabling(talk, joint)
        talk.watching = True

    def held(self) -> np.ndarray | None:
        if not self._armed:
            return None
        return np.array(self._opened().target) * self._sign + self._zero

    def stop(self, level: StopLevel) -> None:
        """Stop the motors: QUICK holds the last commanded position, OFF switches them off.

        The damper of a held joint brakes it, and the spring carries it. With damping alone, an arm would sink
        under its weight. The last measured position is not the goal: a wrong measurement would set the joint
        in motion.
        """
        talk = self._round
        if talk is None or not self._armed or level <= max(self._level, StopLevel.BRAKE):
            return
        self._level = level
        talk.watching = talk.watching and level == StopLevel.QUICK
        if level == StopLevel.OFF:
            talk.request = [Request.DISABLE] * self.arm.dof
        else:
            talk.velocity = [0.0] * self.arm.dof
        talk.cycle(self._patience)

    def _scales(self) -> tuple[np.ndarray, np.ndarray]:
        """Torque and current per unit of an answer's effort, each of shape (n,); NaN where unknown."""
        constant = np.array(self.settings.torque_constant)
        constant[constant == 0.0] = np.nan
        ampere = np.array(self.settings.current_range) > 0.0
        return (
            self._sign * np.where(ampere, constant, 1.0),
            self._sign * np.where(ampere, 1.0, 1.0 / constant),
        )

    def _read_all(self, talk: MotorRound) -> None:
        """Wait until every motor has answered once. Raises LinkLost if a motor does not."""
        self._begin(talk)
        end, silent = self.clock.monotonic() + ANSWERS, list(self._motors)
        while silent and self.clock.monotonic() < end:
            self._cycles(talk, 1)
            silent = [
                motor for motor, state in zip(self._motors, talk.state, strict=True) if state is UNKNOWN
            ]
        if silent:
            first = silent[0]
            raise LinkLost(
                f"{first.name} does not answer on identifier 0x{first.master:03X}. Check its power, ids, "
                "masters and bitrate, and the termination of the bus"
            )

    def _request_enabling(self, talk: MotorRound, joint: int) -> None:
        """Choose a motor's next request until it follows: zero gains, switch on, hold the position."""
        motor, state = self._motors[joint], talk.state[joint]
        if talk.request[joint] is Request.COMMAND or not talk.fresh[joint]:
            return
        self._resting.add(joint, state.position)
        if not self._resting.known(joint):
            return
        self._attempts[joint] += 1
        damiao = motor.family is DAMIAO
        if error_text(motor.family, state.error):
            talk.request[joint], self._attempts[joint] = Request.CLEAR, 0
        elif (damiao and state.error == ON) or (not damiao and self._attempts[joint] > LIMP + BLIND):
            talk.target[joint], talk.velocity[joint] = self._resting.position(joint), 0.0
            talk.request[joint] = Request.COMMAND
        else:
            talk.request[joint] = Request.LIMP if self._attempts[joint] <= LIMP else Request.ENABLE

    def _not_enabled(self, talk: MotorRound) -> str:
        joint = next(j for j, request in enumerate(talk.request) if request is not Request.COMMAND)
        motor, state = self._motors[joint], talk.state[joint]
        if not talk.fresh[joint]:
            return f"{motor.name} does not answer any more. Is it still there?"
        if not self._resting.known(joint):
            return (
                f"{motor.name} is not switched on: {self._resting.doubt(joint)}. Let the arm stand still, "
                "and look at its encoder"
            )
        why = error_text(motor.family, state.error) or "it stays off"
        return f"{motor.name} does not switch on: {why}. Remove the cause, then try again"

    def _set_target(self, talk: MotorRound, command: Command) -> None:
        positions = ((command.position - self._zero) * self._sign).tolist()
        velocities = (command.velocity * self._sign).tolist()
        for motor, where, speed in zip(self._motors, positions, velocities, strict=True):
            if not (abs(where) <= motor.commanded.position and abs(speed) <= motor.commanded.velocity):
                talk.fail(
                    f"{motor.name}: a command of {where:.4g} rad, {speed:.4g} rad/s exceeds the frame's range"
                )
                return
        talk.target, talk.velocity = positions, velocities

    def _check_answers(self, talk: MotorRound) -> None:
        pass  # each answer is checked when it is read

    def _measured(self, talk: MotorRound) -> dict[str, np.ndarray]:
        # One array of five rows would take longer than these of one row each.
        _, position, velocity, effort, temperature = map(np.array, zip(*talk.state, strict=True))
        return {
            "position": position * self._sign + self._zero,
            "velocity": velocity * self._sign,
            "current": effort * self._to_current,
            "torque": effort * self._to_torque,
            "temperature": temperature,
        }

    def _position(self, talk: MotorRound) -> np.ndarray:
        return np.array([state.position for state in talk.state]) * self._sign + self._zero

    def _stopped(self, talk: MotorRound) -> bool:
        return True

    def _detach(self, talk: MotorRound) -> None:
        """Switch the timeout off for motors that must hold; restore the old timeout of the others."""
        held = self._armed and self._level < StopLevel.OFF
        for motor, motor_data in zip(self._motors, self._motor_data, strict=True):
            if motor_data.timeout is not None and self._bus is not None:
                leave(self._bus, motor, 0 if held else motor_data.timeout)
