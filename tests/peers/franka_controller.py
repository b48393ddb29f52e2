"""A Franka controller that moves a simulated arm; its server is franky-sim's and speaks libfranka's protocol.

A process of its own with its own clock of 1 kHz. What franky-sim does not simulate is added: commands that
are missing are extrapolated, 20 in a row are a reflex, and so are jumps with `--strict`. Prints `ready HOST`
(the port is always 1337), then what happens to it. Lines on standard input are faults (see
`Controller.fault`); it ends with standard input.
"""

import argparse
import time

import numpy as np
from franky_sim.base_simulator import InnerRobotState
from franky_sim.franka_robot_protocol import (
    AutomaticErrorRecoveryCommand,
    MoveStatus,
    RobotCommand,
    RobotMode,
    UDPCommand,
)
from franky_sim.franka_robot_server import FrankaRobotServer
from franky_sim.franka_robot_state import FrankaRobotState
from franky_sim.franka_server import BaseCommand, ConnectCommand, ConnectStatus
from franky_sim.simulation_server import LocalHostnames
from sensors import Sensors
from served import ended_of, keep_cycle

STEP = 0.001
LOST = 20
"""Commands that may be missing in a row."""
HARD = 40.0
"""With which the controller brakes by itself [rad/s^2]."""
STANDS_STILL = 0.1
"""Time for which this process was kept from running that is not made up for [s]."""
TORQUE, POSITION, MOTOR, NUMBERS = 126, 147, 270, 320
"""Where tau_J, q and theta begin in a packed state, and how many numbers it begins with."""
TO_ANSWER = 3e-4
"""Time that is left for an answer at least, however late this process is [s]."""
STIFFNESS = 7000.0
"""Of the gears [N m/rad]: by so much the motor is ahead of the joint."""
WHOLE = 3
"""Commands in a row after which the next is looked at: what was extrapolated before is not the host's."""
LIMITS = {"velocity_discontinuity": 10.0, "acceleration_discontinuity": 5000.0}
"""Acceleration and jerk of what is commanded, by the error that follows [rad/s^2], [rad/s^3]."""
ERRORS = {"joint_reflex": 6, "cartesian_reflex": 7, "communication_constraints_violation": 25}
ERRORS |= {"joint_motion_generator_velocity_discontinuity": 14}
ERRORS |= {"joint_motion_generator_acceleration_discontinuity": 15}
HOME = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])


class Obedient:
    """Seven joints that are at once where they are commanded; their torques identify their joint."""

    position, velocity, current = HOME, np.zeros(7), 0.1 * np.arange(1, 8)

    def measure(self):
        return self

    def step(self, position, velocity, seconds):
        self.position, self.velocity = np.array(position), np.array(velocity)


class Robot:
    """An arm as franky-sim's server wants it."""

    has_gripper = False

    def __init__(self, plant):
        self.plant, self.success, self.sensors = plant, 1.0, Sensors()
        self.measured = plant.measure()
        self.target, self.velocity, self.acceleration = np.array(self.measured.position), *np.zeros((2, 7))

    def _set_server(self, server):
        pass

    def joint_position_control(self, target, has_new_command=True):
        pass  # see `Controller.step`

    @property
    def inner_state(self):
        return InnerRobotState(tuple(self.target), tuple(self.velocity), tuple(self.measured.current))

    @property
    def state(self):
        found, torque = self.measured, np.asarray(self.measured.current)
        return FrankaRobotState(
            q=tuple(found.position),
            q_d=tuple(self.target),
            dq=tuple(found.velocity),
            dq_d=tuple(self.velocity),
            tau_J=tuple(torque),
            tau_J_d=tuple(0.5 * torque),
            theta=tuple(found.position + torque / STIFFNESS),
            dtheta=tuple(found.velocity),
            control_command_success_rate=self.success,
        )

    def move(self):
        self.plant.step(self.target, self.velocity, STEP)
        self.measured = self.plant.measure()


class Controller(FrankaRobotServer):
    """The whole controller."""

    def __init__(self, given):
        self.given, self.arm = given, Robot(plant_of(given))
        self.mode, self.errors, self.fresh, self.silent = None, (False,) * 41, None, 0.0
        self.lost = self.whole = self.changes = 0
        self.packed_kind, self.packed = None, b""
        if given.mode:
            self.mode = RobotMode(given.mode)
        super().__init__(self.arm, [given.bind] if given.bind else LocalHostnames())

    @property
    def robot_state(self):
        state = super().robot_state
        mode = state.robot_mode if self.mode is None else self.mode
        return state.replace(robot_mode=mode, errors=self.errors, reflex_reason=self.errors)

    def _get_state_bytes(self):
        """What franky-sim packs, with what changes in each cycle written over: packing takes half of one."""
        kind = self.current_motion_id > 0, self.mode, self.errors, self.changes
        if kind != self.packed_kind:
            self.packed_kind, self.packed = kind, bytearray(super()._get_state_bytes())
        arm = self.arm
        found, torque = arm.measured, np.asarray(arm.measured.current)
        numbers = np.frombuffer(self.packed, "<f4", NUMBERS)
        for first, values in (
            (TORQUE, (torque, 0.5 * torque)),
            (POSITION, (arm.sensors.shown(found.position), arm.target, found.velocity, arm.velocity)),
            (MOTOR, (found.position + torque / STIFFNESS, found.velocity)),
        ):
            numbers[first : first + 7 * len(values)] = np.concatenate(values)
        self.packed[-4:] = np.float32(arm.success).tobytes()
        return bytes(self.packed)

    def start_motion(self, controller_mode, motion_generator_mode, motion_id):
        if self.mode is not None:
            raise ValueError(f"robot mode is {self.mode.name}")
        super().start_motion(controller_mode, motion_generator_mode, motion_id)
        self.changes += 1
        self.lost = self.whole = 0
        print("motion started", flush=True)

    def stop_motion(self, send_preemption_signal=True):
        if self.current_motion_id:
            print("motion stopped" if send_preemption_signal else "motion ended", flush=True)
        super().stop_motion(send_preemption_signal)
        self.changes += 1

    def _reset_state(self):
        if self.current_motion_id:
            print("connection lost while moving", flush=True)
        super()._reset_state()
        self.fresh = None

    def _handle_udp_command(self, data):
        command = UDPCommand.from_bytes(data)
        late = command.message_id < self._FrankaServer__message_id - 1
        if not command.motion_generation_finished and not late:
            self.fresh = np.array(command.q_c)
        super()._handle_udp_command(data)

    def _post_process_commands(self):
        arm, before = self.arm, self.arm.target
        if not self.current_motion_id:
            slower = np.maximum(np.abs(arm.velocity) - HARD * STEP, 0.0)
            arm.target = before + np.sign(arm.velocity) * slower * STEP
        elif self.fresh is not None:
            self.lost, self.whole, arm.target = 0, self.whole + 1, self.fresh
            self.look(self.fresh)
        else:
            self.lost, self.whole = self.lost + 1, 0
            arm.target = before + arm.velocity * STEP + arm.acceleration * STEP**2
            if self.lost > self.given.patience:
                self.reflex("communication_constraints_violation")
        arm.success += 0.01 * ((self.lost == 0) - arm.success)
        velocity = (arm.target - before) / STEP
        arm.acceleration, arm.velocity = (velocity - arm.velocity) / STEP, velocity
        self.fresh = None
        arm.move()

    def look(self, target):
        """What the controller checks of a stream of commands."""
        acceleration = ((target - self.held) / STEP - self.arm.velocity) / STEP
        found = np.abs(acceleration), np.abs(acceleration - self.arm.acceleration) / STEP
        for value, (name, limit) in zip(found, LIMITS.items(), strict=True):
            if self.given.strict and self.whole > WHOLE and value.max() > limit + 1e-3:
                self.reflex(f"joint_motion_generator_{name}")
                return

    def reflex(self, name, number=None):
        flags = [False] * 41
        flags[ERRORS[name] if number is None else number] = True
        self.errors = tuple(flags)
        self.abort(RobotMode.kReflex, MoveStatus.kReflexAborted, name)

    def abort(self, mode, status, why):
        self.mode, motion = mode, self.current_motion_id
        print(f"aborted: {why}", flush=True)
        self.stop_motion(send_preemption_signal=False)
        self.reset_current_motion_id()
        if motion and self.tcp_connected:
            BaseCommand.send_response(self._tcp_socket, RobotCommand.kMove, motion, status)

    def one_cycle(self):
        self.held = self.arm.target
        self.process_commands()
        if self.silent > 0.0:
            self.silent -= STEP
            self._FrankaServer__message_id += 1
        else:
            self.send_state()

    def fault(self, words):
        if self.arm.sensors.told(words):
            return
        if words[0] == "reflex":
            self.reflex(words[1])
        elif words[0] == "error":
            self.reflex(f"error {words[1]}", int(words[1]))
        elif words[0] == "user":
            self.abort(
                RobotMode.kUserStopped, MoveStatus.kPreemptedDueToActivatedSafetyFunctions, "user stop"
            )
        elif words[0] == "hold":  # states are lost: the network's fault
            self.silent = float(words[1])
        elif words[0] == "cut":
            self.reset_state()
        elif words[0] == "recover":
            self.mode, self.errors = None, (False,) * 41

    def run(self, ended):
        deadline = time.monotonic()
        while not ended():
            deadline += self.given.slow * STEP
            now = time.monotonic()
            if now > deadline + (STANDS_STILL if self.given.slow == 1.0 else 0.0):
                deadline = now  # its clock stands still too: nothing is late for an arm that did not go on
            time.sleep(max(deadline - now, TO_ANSWER))
            self.one_cycle()


def plant_of(given):
    """The arm, whose import takes a while unless it is the obedient one."""
    if given.robot == "obedient":
        return Obedient()
    if __package__:
        from .arm import make_plant
    else:
        from arm import make_plant
    return make_plant(given.robot, given.start, given.seed)


def recover():
    """Franky-sim has no errors that could be recovered from."""
    reply = AutomaticErrorRecoveryCommand.handle

    def handle(self, server):
        server.fault(["recover"])
        reply(self, server)

    AutomaticErrorRecoveryCommand.handle = handle


def refuse(version):
    """A server of another version of the protocol."""

    def handle(self, server, command_type_struct="I"):
        status = ConnectStatus.kIncompatibleLibraryVersion
        rest = version.to_bytes(2, "little") + bytes(5)
        BaseCommand.send_response(self.client_socket, self.command_type, self.command_id, status, rest)

    ConnectCommand.handle = handle


def parser():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="obedient", help="or the file of a robot with seven joints")
    parser.add_argument("--start", type=lambda text: [float(one) for one in text.split(",")], help="[rad]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--bind", default="", help="address; by default the first of 127.x.y.z that is free")
    parser.add_argument("--version", type=int, default=0, help="of the protocol, other than the library's")
    parser.add_argument("--mode", type=int, default=0, help="of the robot, such as 5 for user stopped")
    parser.add_argument("--patience", type=int, default=LOST, help="commands that may be missing in a row")
    parser.add_argument("--strict", action="store_true", help="a jump in what is commanded is a reflex")
    parser.add_argument("--slow", type=float, default=1.0, help="times that a millisecond takes, at least")
    parser.add_argument("--fifo", type=int, default=0, metavar="PRIORITY")
    return parser


def main():
    given = parser().parse_args()
    recover()
    if given.version:
        refuse(given.version)
    controller = Controller(given)
    ended = ended_of(controller.fault)
    keep_cycle(given.fifo)
    controller.init()
    print("ready", controller.hostname, flush=True)
    controller.run(ended)


if __name__ == "__main__":
    main()
