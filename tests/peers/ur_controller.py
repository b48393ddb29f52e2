"""A Universal Robots controller that moves a simulated arm: RTDE, programs and dashboard over real TCP.

A process of its own with its own clock. Programs are run as they are sent; `servoj` smooths, and so has a
latency. Prints `ready HOST RTDE PROGRAM DASHBOARD` (ports), then what happens to it. Lines on standard input
are faults (see `Controller.fault`); it ends with standard input.
"""

import argparse
from collections import deque

import numpy as np
from can_arm import make_arm
from sensors import Sensors
from served import ended_of, keep_cycle
from ur_script import ScriptError, program
from ur_servers import RtdeClient, TextServer, listening
from virtual_clock import of_this_peer

CLOCK = of_this_peer()
STEP = {"cb3": 0.008, "e": 0.002}
VERSION = {"cb3": (3, 15, 8, 106339), "e": (5, 12, 4, 1101319)}
NORMAL, PROTECTIVE, EMERGENCY = 1, 3, 7
POWER_OFF, RUNNING = 3, 7
STOPPED, PLAYING, PAUSED = 1, 2, 4
HARD = 30.0
"""With which a protective stop brakes [rad/s^2]."""
STANDS_STILL = 0.1
"""Time for which this process was kept from running that is not made up for, but skipped [s]."""


class Controller:
    """The whole controller."""

    def __init__(self, given):
        self.given, self.step = given, STEP[given.series]
        self.version = tuple(map(int, given.version.split("."))) if given.version else VERSION[given.series]
        self.plant = make_arm(given.robot, given.start, given.seed)
        self.speed = np.zeros(6) if given.robot == "obedient" else None  # a plant with drives needs none
        self.measured = self.plant.measure()
        self.target = self.followed = np.array(self.measured.position)
        self.velocity = np.zeros(len(self.target))
        count = round(given.latency / self.step) + 1
        self.smoothing = [deque([self.target] * count, maxlen=count) for _ in range(2)]
        self.robot_mode, self.safety_mode = given.robot_mode, given.safety_mode
        self.slider, self.remote, self.paused = given.slider, not given.local, False
        self.program, self.time = None, 1000.0 + 0.5 * self.step
        self.inputs = {f"input_{kind}_register_{k}": 0 for kind in ("int", "double") for k in range(48)}
        self.outputs = {f"output_{kind}_register_{k}": 0 for kind in ("int", "double") for k in range(48)}
        self.rtde, self.programs, self.dashboard = (listening(given.bind) for _ in range(3))
        self.clients, self.senders, self.askers = [], [], []
        self.runs, self.clock, self.sensors = 0.0, "", Sensors()
        self.asked_to = "answer"  # or be "silent", "flood", or "babble" without the end of a line
        self.now = self.values()

    # What is measured, as RTDE calls it.

    def value(self, name):
        """A type and a value; KeyError for a name that is not known."""
        registers = self.inputs if name in self.inputs else self.outputs
        if name in registers:
            return {"int": "INT32", "double": "DOUBLE"}[name.split("_")[1]], registers[name]
        return self.now[name]

    def values(self):
        measured, dof = self.measured, len(self.target)
        joint_mode = 253 if self.robot_mode == RUNNING else 239
        state = PAUSED if self.paused else PLAYING if self.program else STOPPED
        return {
            "timestamp": ("DOUBLE", self.shown_time()),
            "actual_q": ("VECTOR6D", self.sensors.shown(measured.position)),
            "actual_qd": ("VECTOR6D", measured.velocity),
            "target_q": ("VECTOR6D", self.target),
            "target_qd": ("VECTOR6D", self.velocity),
            "actual_current": ("VECTOR6D", measured.current),
            "joint_temperatures": ("VECTOR6D", measured.temperature),
            "joint_mode": ("VECTOR6INT32", [joint_mode] * dof),
            "robot_mode": ("INT32", self.robot_mode),
            "safety_mode": ("INT32", self.safety_mode),
            "runtime_state": ("UINT32", state),
            "robot_status_bits": ("UINT32", (self.robot_mode >= 4) | 2 * bool(self.program)),
            "safety_status_bits": ("UINT32", 1 << (self.safety_mode - 1)),
            "speed_scaling": ("DOUBLE", 0.0 if self.paused else self.slider),
            "target_speed_fraction": ("DOUBLE", self.slider),
            "actual_execution_time": ("DOUBLE", 0.0),
        }

    def shown_time(self):
        """What the clock shows: the time, unless it has failed."""
        if self.clock == "stop":
            self.stopped_at = getattr(self, "stopped_at", self.time)
        shown = {"stop": getattr(self, "stopped_at", 0.0), "back": 2000.0 - self.time}
        return shown.get(self.clock) or {"nan": float("nan"), "huge": 1e30}.get(self.clock, self.time)

    def type_of(self, name):
        if name in self.given.unknown.split(","):
            return "NOT_FOUND"
        try:
            return self.value(name)[0]
        except KeyError:
            return "NOT_FOUND"

    def type_of_input(self, name):
        if name not in self.inputs or name in self.given.unknown.split(","):
            return "NOT_FOUND"
        return "IN_USE" if name in self.given.in_use.split(",") else self.value(name)[0]

    # Its cycle.

    def one_cycle(self):
        self.accept()
        for client in self.clients:
            client.receive()
        self.run_program()
        self.followed = self.target
        for window in self.smoothing:  # two means, one of the other, each late by half its length
            window.append(self.followed)
            self.followed = np.mean(window, axis=0)
        if self.robot_mode == RUNNING:
            self.plant.step(self.followed, self.speed, self.step)
        self.measured = self.plant.measure()
        self.time += self.step
        self.now = self.values()
        for client in self.clients:
            client.dispatch()
        self.clients = [client for client in self.clients if client.open]

    def run_program(self):
        before = self.target
        if self.runs:
            self.velocity = self.runs * np.eye(len(before))[1]
            self.target = before + self.step * self.velocity
            return
        if self.program and not self.paused and self.safety_mode == NORMAL:
            try:
                next(self.program)
            except StopIteration:
                self.end_program("to its end")
        else:
            self.brake(HARD)
        self.velocity = (self.target - before) / self.step

    def end_program(self, how):
        if self.program:
            print(f"program ended: {how}", flush=True)
        self.program = None

    def brake(self, deceleration):
        """A step of the way that is left; whether there is one."""
        slower = np.maximum(np.abs(self.velocity) - deceleration * self.step, 0.0)
        self.target = self.target + np.sign(self.velocity) * slower * self.step
        return bool(slower.any())

    # What programs call.

    def servoj(self, position, acceleration, velocity, seconds, lookahead, gain):
        assert len(position) == 6
        assert 0.03 <= lookahead <= 0.2
        assert 100 <= gain <= 2000
        start = self.target
        steps = max(round(seconds / self.step * (1.0 / self.slider)), 1)
        for step in range(1, steps + 1):
            self.target = start + step / steps * (np.array(position) - start)
            yield

    def stopj(self, deceleration):
        print("stopping", flush=True)
        while self.brake(deceleration):
            yield

    def sync(self):
        yield

    def functions(self):
        return {
            "servoj": self.servoj,
            "stopj": self.stopj,
            "sync": self.sync,
            "textmsg": lambda *words: print(*words, flush=True),
            "read_input_integer_register": lambda k: self.inputs[f"input_int_register_{k}"],
            "read_input_float_register": lambda k: self.inputs[f"input_double_register_{k}"],
            "write_output_integer_register": self.write_output,
        }

    def write_output(self, number, value):
        self.outputs[f"output_int_register_{number}"] = value

    def begin_program(self, text):
        if not self.remote or self.robot_mode != RUNNING or self.safety_mode != NORMAL:
            print("program refused", flush=True)
            return
        try:
            self.program = program(text, self.functions())
            print("program started", flush=True)
        except ScriptError as error:
            print(f"program wrong: {error}", flush=True)

    # Its servers.

    def accept(self):
        for server, makes, those in (
            (self.rtde, lambda link: RtdeClient(link, self), self.clients),
            (self.programs, lambda link: TextServer(link, self.begin_program), self.senders),
            (self.dashboard, self.greet, self.askers),
        ):
            try:
                those.append(makes(server.accept()[0]))
            except BlockingIOError:
                pass
        for one in (*self.senders, *self.askers):
            one.receive()
        for one in self.askers if self.asked_to in ("flood", "babble") else ():
            one.send((b"x\n" if self.asked_to == "flood" else b"x") * 20000)
        self.senders, self.askers = ([x for x in those if x.open] for those in (self.senders, self.askers))

    def greet(self, link):
        link.sendall(b"Connected: Universal Robots Dashboard Server\n")
        return TextServer(link, lambda line: self.tell(link, self.answer(line.strip())), "\n")

    def tell(self, link, text):
        if self.asked_to == "answer":
            link.sendall(f"{text}\n".encode())

    def answer(self, line):
        if line == "is in remote control" and self.given.series == "e":
            return str(self.remote).lower()
        if line == "power off" and self.runs:
            return "Powering off"  # and it does not
        if line == "power off":
            self.robot_mode = POWER_OFF
            self.end_program("power off")
            print("powered off", flush=True)
            return "Powering off"
        return f"could not understand: '{line}'"

    # What goes wrong.

    def fault(self, words):
        if self.sensors.told(words):
            return
        if words[0] == "dashboard":  # what it does with questions from then on
            self.asked_to = words[1]
        elif words[0] in ("protective", "emergency"):
            self.safety_mode = PROTECTIVE if words[0] == "protective" else EMERGENCY
            self.end_program(words[0])
        elif words[0] == "slider":
            self.slider = float(words[1])
        elif words[0] == "pause":
            self.paused = True
        elif words[0] == "halt":
            self.end_program("at the pendant")
        elif words[0] == "hold":  # packages wait: the network's fault
            for client in self.clients:
                client.hold(float(words[1]))
        elif words[0] == "cut":
            for client in self.clients:
                client.close()
        elif words[0] == "say":
            for client in self.clients:
                client.say(" ".join(words[1:]))
        elif words[0] == "runs":  # joint 2, with a speed [rad/s], whatever it is told
            self.runs = float(words[1])
        elif words[0] == "clock":
            self.clock = words[1]
        elif words[0] == "unpowered":
            self.robot_mode = POWER_OFF
            self.end_program("power lost")
        elif words[0] == "inputs":
            print("inputs", self.inputs, flush=True)

    def run(self, ended):
        deadline = CLOCK.monotonic()
        while not ended():
            deadline += self.step
            now = CLOCK.monotonic()
            if now > deadline + STANDS_STILL:
                missed = int((now - deadline) / self.step)
                deadline += missed * self.step
                self.time += missed * self.step  # a controller's clock goes on
                print(f"stood still for {missed} cycles", flush=True)
            CLOCK.sleep(max(deadline - now, 0.0))
            self.one_cycle()


def parser():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--robot", default="cobot", help="or obedient: six joints that follow their targets at once"
    )
    parser.add_argument("--start", type=lambda text: [float(one) for one in text.split(",")], help="[rad]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--bind", default="127.0.0.1")
    parser.add_argument("--series", default="e", choices=tuple(STEP))
    parser.add_argument("--version", default="", help="such as 5.12.4.0")
    parser.add_argument("--protocol", type=int, default=2, help="newest version of RTDE that it knows")
    parser.add_argument("--latency", type=float, default=0.032, help="of servoj [s]")
    parser.add_argument("--slider", type=float, default=1.0)
    parser.add_argument("--local", action="store_true", help="not in remote control")
    parser.add_argument("--robot-mode", type=int, default=RUNNING)
    parser.add_argument("--safety-mode", type=int, default=NORMAL)
    parser.add_argument("--unknown", default="", help="names of RTDE that it does not have, with commas")
    parser.add_argument("--in-use", default="", help="inputs that another client writes")
    parser.add_argument("--fifo", type=int, default=0, metavar="PRIORITY")
    return parser


def main():
    given = parser().parse_args()
    controller = Controller(given)
    ended = ended_of(controller.fault)
    keep_cycle(given.fifo)
    servers = (controller.rtde, controller.programs, controller.dashboard)
    print("ready", given.bind, *(one.getsockname()[1] for one in servers), flush=True)
    controller.run(ended)


if __name__ == "__main__":
    main()
