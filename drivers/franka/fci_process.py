"""The process that talks to the controller: one state and one command a millisecond, by the maker's library.

The library may wait without end, or end the process where a motion cannot be ended; in a process of its own
neither takes the run with it. When the driver's process dies, this one stops the arm; when this one dies, the
controller does, 20 ms later.
"""

import gc
import os
import signal
import socket
import sys
import time
from contextlib import suppress
from typing import Any

import numpy as np
import pylibfranka as fci

from . import fci_messages as m
from .fci_messages import error_code, read_target, record
from .target_stream import CYCLE, JOINTS, TargetStream

READ = 1 << 12
"""Bytes of the longest message."""
FORCES, USUAL = 6, 100.0
"""Number of forces and torques at the hand; threshold of what is left at zero beside one that is not."""
REFUSED = (
    fci.FrankaException, fci.CommandException, fci.ControlException, fci.NetworkException,
    fci.InvalidOperationException, fci.RealtimeException,
)  # fmt: skip


class FciProcess:
    """Serves one driver; so many commands wait before the first is given out."""

    def __init__(self, link: socket.socket, address: str, held_back: int, real_time: bool) -> None:
        self._link, self._held_back = link, held_back
        config = fci.RealtimeConfig.kEnforce if real_time else fci.RealtimeConfig.kIgnore
        self._robot = fci.Robot(address, config)
        self._control: Any = None
        self._stream: TargetStream | None = None
        self._motion, self._time = m.IDLE, 0.0
        self._flowing = self._asked = self._ended = False
        self._untold: list[bytes] = []
        self._tell(m.READY, fci.__version__.encode())

    def prepare(self, torque: float, force: float, recover: bool) -> None:
        """Thresholds of collisions, and recovery from a reflex; zero and false leave them."""
        if torque or force:
            torques, forces = [torque or USUAL] * JOINTS, [force or USUAL] * FORCES
            self._robot.set_collision_behavior(torques, torques, forces, forces)
        if recover and self._robot.read_once().robot_mode == fci.RobotMode.Reflex:
            self._robot.automatic_error_recovery()

    def run(self) -> None:
        """Until the driver has gone and the arm is at rest."""
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
        """End the motion without a way to rest: the controller brakes as hard as it can."""
        if self._control is not None:
            self._control, self._motion = None, m.ENDED

    def _command(self, state: Any) -> None:
        """Give out what belongs to this millisecond; what a lost state would have had is left out."""
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
        with suppress(OSError):  # a driver that does not look misses some
            self._link.send(message)

    def _tell(self, kind: bytes, text: bytes) -> None:
        """Report something, which waits where the driver does not look: unlike states, it is not lost."""
        self._untold.append(kind + text)
        self._tell_untold()

    def _tell_untold(self) -> None:
        with suppress(OSError):
            while self._untold:
                self._link.send(self._untold[0])
                del self._untold[0]


def main() -> None:
    """With a socket, the address, and settings, as `fci_link` starts it."""
    link = socket.socket(fileno=int(sys.argv[1]))
    link.setblocking(False)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    address, held_back, real_time, torque, force, recover = sys.argv[2:]
    try:
        process = FciProcess(link, address, int(held_back), real_time == "1")
        process.prepare(float(torque), float(force), recover == "1")
        gc.collect()
        gc.freeze()
        gc.disable()
        process.run()
    except REFUSED as error:
        with suppress(OSError):
            link.send(m.FATAL + str(error).encode())
        # An ordinary end would let the library wait for a controller that does not answer.
        os._exit(1)


if __name__ == "__main__":
    main()
