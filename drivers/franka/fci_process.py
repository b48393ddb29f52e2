"""Process that talks to the controller through the maker's library: one state and one command a millisecond.

The library may block forever, or end the process if a motion cannot be ended; in a separate process, neither
ends the run. If the driver's process dies, this process stops the arm; if this process dies, the controller
stops the arm 20 ms later.
"""

import gc
import os
import signal
import socket
import sys
import time
from contextlib import suppress
from typing import Any

import msgspec
import numpy as np
import pylibfranka as fci

from . import fci_messages as m
from .fci_messages import error_code, read_target, record
from .settings import FrankaSettings
from .target_stream import CYCLE, JOINTS, TargetStream

READ = 1 << 12
"""Maximum length of a message [bytes]."""
FORCES, USUAL = 6, 100.0
"""Number of forces and torques at the hand; threshold that replaces a zero if the other is set."""
REFUSED = (
    fci.FrankaException, fci.CommandException, fci.ControlException, fci.NetworkException,
    fci.InvalidOperationException, fci.RealtimeException,
)  # fmt: skip


class FciProcess:
    """Serves one driver."""

    def __init__(self, link: socket.socket, settings: FrankaSettings) -> None:
        self._link = link
        self._held_back = max(round(settings.buffer / CYCLE), 1)
        config = fci.RealtimeConfig.kEnforce if settings.real_time else fci.RealtimeConfig.kIgnore
        self._robot = fci.Robot(settings.address, config)
        self._control: Any = None
        self._stream: TargetStream | None = None
        self._motion, self._time = m.IDLE, 0.0
        self._flowing = self._asked = self._ended = False
        self._untold: list[bytes] = []
        self._tell(m.READY, fci.__version__.encode())

    def prepare(self, settings: FrankaSettings) -> None:
        """Set collision thresholds, where zero changes nothing, and recover from a reflex if requested."""
        torque, force = settings.collision_torque, settings.collision_force
        if torque or force:
            torques, forces = [torque or USUAL] * JOINTS, [force or USUAL] * FORCES
            self._robot.set_collision_behavior(torques, torques, forces, forces)
        if settings.recover and self._robot.read_once().robot_mode == fci.RobotMode.Reflex:
            self._robot.automatic_error_recovery()

    def run(self) -> None:
        """Run until the driver has disconnected and the arm is at rest."""
        while not self._ended or self._control is not None:
            state = self._read()
            self._listen(state)
            if self._control is not None:
                self._command(state)
            self._report(state)

    def _read(self) -> Any:
        if self._control is None:
            return self._robot.read_once()
        try:
            state, _ = self._control.readOnce()
            return state
        except fci.ControlException as error:
            self._over(str(error))
            return self._robot.read_once()

    def _listen(self, state: Any) -> None:
        while not self._ended:
            try:
                message = self._link.recv(READ)
            except BlockingIOError:
                return
            except OSError:
                message = b""
            if not message:
                self._ended = True
                self._stop("the driver's process has gone: the arm was stopped")
                return
            self._take(message[:1], message[1:], state)

    def _take(self, kind: bytes, body: bytes, state: Any) -> None:
        if kind == m.TARGET:
            self._follow(read_target(body), state)
        elif kind == m.STOP:
            self._stop("")
        elif kind == m.OFF:
            self._let_go()
        elif kind == m.FLOW:
            self._flowing = True
        elif kind == m.ASK:
            self._asked = True

    def _follow(self, position: np.ndarray, state: Any) -> None:
        if self._motion == m.IDLE:
            self._stream = TargetStream(np.array(state.q_d), self._held_back)
            try:
                self._control = self._robot.start_joint_position_control(fci.ControllerMode.JointImpedance)
                self._motion, self._time = m.FOLLOWING, self._robot_time(state)
            except (fci.ControlException, fci.CommandException) as error:
                self._over(str(error))
        if self._stream is not None:
            self._stream.add(position)

    def _robot_time(self, state: Any) -> float:
        return float(state.time.to_sec())

    def _stop(self, reason: str) -> None:
        if self._motion == m.FOLLOWING and self._stream is not None:
            self._motion = m.STOPPING
            self._stream.stop(reason)

    def _let_go(self) -> None:
        """End the motion at once: the controller brakes as hard as it can."""
        if self._control is not None:
            self._control, self._motion = None, m.ENDED

    def _command(self, state: Any) -> None:
        """Send the command of this millisecond; commands of lost states are skipped."""
        assert self._stream is not None
        now = self._robot_time(state)
        cycles = max(round((now - self._time) / CYCLE), 1)
        self._time = now
        step = self._stream.next(cycles)
        if self._stream.reason and self._motion == m.FOLLOWING:
            self._motion = m.STOPPING
            self._tell(m.FAULT, self._stream.reason.encode())
        command = fci.JointPositions(step.position.tolist())
        command.motion_finished = step.finished
        try:
            self._control.writeOnce(command)
        except fci.ControlException as error:
            self._over(str(error))
        if step.finished:
            self._control, self._motion = None, m.ENDED

    def _over(self, text: str) -> None:
        self._control, self._motion = None, m.ENDED
        self._tell(m.FAULT, text.encode())

    def _report(self, state: Any) -> None:
        self._tell_untold()
        if self._untold or not (self._flowing or self._asked):
            return
        self._asked = False
        errors = state.current_errors or state.last_motion_errors
        reflex = state.robot_mode == fci.RobotMode.Reflex
        message = record(
            time=round(1e9 * self._robot_time(state)),
            arrival=time.monotonic_ns(),
            state=[
                state.robot_mode.value,
                error_code(str(errors)) if reflex or state.current_errors else 0,
                state.control_command_success_rate,
                *(*state.tau_J_d, *state.theta, *state.dtheta),
            ],
            motion=self._motion,
            **{name: getattr(state, name) for name in m.VECTORS},
        )
        with suppress(OSError):  # a driver that does not read misses states
            self._link.send(message)

    def _tell(self, kind: bytes, text: bytes) -> None:
        """Report a text, which waits until the driver reads it: unlike a state, it is not lost."""
        self._untold.append(kind + text)
        self._tell_untold()

    def _tell_untold(self) -> None:
        with suppress(OSError):
            while self._untold:
                self._link.send(self._untold[0])
                del self._untold[0]


def main() -> None:
    """Run the process with the arguments from `fci_link`: a socket and the driver's settings."""
    link = socket.socket(fileno=int(sys.argv[1]))
    link.setblocking(False)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    settings = msgspec.json.decode(sys.argv[2], type=FrankaSettings)
    try:
        process = FciProcess(link, settings)
        process.prepare(settings)
        gc.collect()
        gc.freeze()
        gc.disable()
        process.run()
    except REFUSED as error:
        with suppress(OSError):
            link.send(m.FATAL + str(error).encode())
        # On a normal exit, the library would wait for a controller that does not answer.
        os._exit(1)


if __name__ == "__main__":
    main()
