"""A KUKA controller that moves a simulated arm: RSI over real UDP, as a process of its own.

It sends from a port of its own choice every cycle by its own clock, and acts on an answer only if that came
before the next telegram is sent. Prints `ready`, and at its end one line of JSON. Ends on SIGTERM, at the end
of standard input or after --seconds.
"""

import argparse
import json
import signal
import socket
import struct
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections import Counter, deque

import numpy as np
from arm import make_plant
from krc_context import Context
from sensors import Sensors
from served import keep_cycle
from virtual_clock import of_this_peer

from exidyn.identification.robot_files.robot_file import read_model

CLOCK = of_this_peer()
STAMPED = 35  # SO_TIMESTAMPNS


class Faults:
    """What goes wrong, by number of the cycle since the first answer, or the start if none is expected."""

    def __init__(self, given):
        self.drop = cycles(given.drop)
        self.twice = cycles(given.duplicate)
        self.swap = cycles(given.reorder)
        self.delays = timed(given.delay)
        self.stalls = timed(given.stall)
        self.jumps = timed(given.jump)
        self.restart = cycles(given.restart)

    def held_back(self, number, cycle):
        """How long the telegram of a cycle is under way [s]."""
        late = self.delays.get(number, 0.0)
        for first, seconds in self.stalls.items():
            if 0 <= (number - first) * cycle < seconds:
                late = max(late, seconds - (number - first) * cycle)
        return late


def cycles(text):
    """Numbers of `3,7-9`."""
    parts = [part.split("-") for part in text.split(",") if part]
    return {k for part in parts for k in range(int(part[0]), int(part[-1]) + 1)}


def timed(text):
    """Cycle -> number of `100:0.02,200:0.1`."""
    return {int(k): float(v) for k, v in (part.split(":") for part in text.split(",") if part)}


def exchanged(text, axes):
    """Places of the outputs that the inputs of AXISCORR are linked to, of `2:3` or of a ring, `1:2:3`."""
    outputs = list(range(axes))
    ring = [int(part) - 1 for part in text.split(":") if part]
    for place, following in zip(ring, [*ring[1:], *ring[:1]], strict=True):
        outputs[place] = following
    return tuple(outputs)


class Config:
    """The file that the controller has."""

    def __init__(self, path):
        root = ElementTree.parse(path).getroot()
        self.address, self.port = root.findtext("CONFIG/IP_NUMBER"), int(root.findtext("CONFIG/PORT"))
        self.sentype = root.findtext("CONFIG/SENTYPE")
        self.only_send = root.findtext("CONFIG/ONLYSEND") == "TRUE"
        self.sends = [e.get("TAG") for e in root.iterfind("SEND/ELEMENTS/ELEMENT")]
        receives = {e.get("TAG"): e.get("HOLDON") for e in root.iterfind("RECEIVE/ELEMENTS/ELEMENT")}
        self.tags = [tag for tag in receives if "." in tag]
        self.hold = all(receives[tag] == "1" for tag in self.tags)
        self.stop = "Stop" if "Stop" in receives else ""


class Controller:
    """The whole controller."""

    def __init__(self, given):
        self.given, self.config, self.faults = given, Config(given.config), Faults(given)
        self.cycle = given.cycle or (0.012 if given.generation == "KRC2" else 0.004)
        self.robot = read_model(given.robot).robot
        self.sign = np.array(given.sign or np.ones(self.robot.dof))
        self.zero = np.array(given.zero or np.zeros(self.robot.dof))
        start = None if given.start is None else self.joints(np.array(given.start))
        self.plant = make_plant(given.robot, start, given.seed)
        self.measured = self.plant.measure()
        self.pose = self.target = self.rest = self.measured.position
        self.under_way, self.sensors = deque(maxlen=given.lag + 1), Sensors()
        self.furthest = 0.0
        self.noise = np.random.default_rng(given.seed)
        self.ipoc = 4208163634
        self.total = Counter()
        self.rejected = Counter()
        self.worst = 0
        self.latencies = []
        self.outbox = []
        self.sent = 0
        self.first = None
        self.overtaken = b""
        self.socket = None
        self.runs, self.run_by, self.run_from = 0.0, 0.0, None
        self.begin()

    def begin(self):
        """RSI_ON: a new session, from where the arm stands."""
        if self.socket:
            self.add_up()
            self.socket.close()
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((self.given.bind, 0))
        self.socket.setblocking(False)
        self.socket.setsockopt(socket.SOL_SOCKET, STAMPED, 1)
        self.pose = self.target
        n = self.robot.dof
        self.context = Context(
            sentype=self.config.sentype,
            tags=tuple(self.config.tags[:n]),
            hold=self.config.hold,
            stop_tag=self.config.stop,
            cycle=self.cycle,
            limit=np.full(n, self.given.axiscorr),
            overall=np.full(n, self.given.axiscorrmon),
            timeout=self.given.timeout,
            speed=1.1 * np.degrees(self.robot.limits.velocity),
            only_send=self.config.only_send,
            relative=self.given.mode == "relative",
            linked=np.array(self.given.linked or np.ones(n)),
            outputs=exchanged(self.given.exchange, n),
        )

    def add_up(self):
        for name in ("late", "clamped", "answered"):
            self.total[name] += getattr(self.context, name)
        self.rejected += self.context.rejected
        self.worst = max(self.worst, self.context.worst)
        self.total["farthest"] = max(self.total["farthest"], self.context.farthest)

    def joints(self, degrees):
        return self.sign * np.radians(degrees) + self.zero

    def axes(self, position):
        return self.sign * np.degrees(position - self.zero)

    def run(self, ended):
        deadline = CLOCK.monotonic()
        number = 0
        while not ended(number) and (not self.context.stopped or self.runs):
            deadline += self.cycle
            if CLOCK.monotonic() > deadline + self.cycle:  # not the controller's fault, but this computer's
                self.total["own_stalls"] += 1
                deadline = CLOCK.monotonic()
            self.send_until(deadline)
            self.one_cycle(number, deadline)
            number += 1
        self.total["cycles"] = number
        stopped = self.context.stopped
        self.add_up()
        return {
            **self.total,
            "stopped": stopped,
            "rejected": dict(self.rejected),
            "max_consecutive_late": self.worst,
            "furthest": self.furthest,
            "latency_us": percentiles(self.latencies),
            "latencies_us": [round(1e-3 * one) for one in self.latencies],
        }

    def one_cycle(self, number, deadline):
        self.collect()
        if number * self.cycle < self.given.movecorr:
            self.context.correction = np.zeros(self.robot.dof)
        self.under_way.append(self.context.step())
        correction = self.under_way[0]
        if self.context.stopped and not self.runs:
            return
        self.furthest = max(self.furthest, np.abs(self.axes(self.measured.position - self.rest)).max())
        if self.first is None and (self.context.answered or self.context.only_send):
            self.first = number
        since = -1 if self.first is None else number - self.first
        if since in self.faults.restart:
            self.begin()
            correction = self.context.correction
        if 0 <= self.given.additive <= since:
            self.context.relative = True
        self.runs = next((speed for cycle, speed in self.given.runs.items() if cycle <= since), 0.0)
        self.run_by += np.radians(self.runs) * self.cycle
        self.ipoc += round(1e3 * self.cycle) + int(self.faults.jumps.get(since, 0))
        self.dispatch(number, since, deadline)
        target = self.joints(self.axes(self.pose) + correction) + self.by_program(number)
        if self.runs:  # axis 2, from where it is, whatever the answers say
            self.run_from = target if self.run_from is None else self.run_from
            target = self.run_from + self.run_by * np.eye(self.robot.dof)[1]
        self.plant.step(target, None, self.cycle)
        self.measured, self.target = self.plant.measure(), target

    def unrest(self):
        """What positions are wrong by [deg]."""
        return self.given.noise * self.noise.standard_normal(self.robot.dof)

    def by_program(self, number):
        """How far the controller's own program has moved: a slow swing where it does [rad]."""
        seconds = number * self.cycle
        return np.radians(self.given.swing) * (1 - np.cos(2.0 * seconds)) * np.ones(self.robot.dof)

    def collect(self):
        """Answers to the telegram before; only one that is there by now counts."""
        while True:
            try:
                data, extra, _, _ = self.socket.recvmsg(65535, 64)
            except BlockingIOError:
                return
            if self.context.answer(data, self.ipoc) and self.sent and extra:
                seconds, rest = struct.unpack("@ll", extra[0][2][:16])
                self.latencies.append(seconds * 1_000_000_000 + rest - self.sent)

    def dispatch(self, number, since, deadline):
        late = self.faults.held_back(since, self.cycle)
        data = self.telegram(number)
        if since in self.faults.drop or 0 <= self.given.mute <= since:
            return
        if late:
            self.outbox.append((deadline + late, data))
            self.outbox.sort()
            self.sent = 0
            return
        if since in self.faults.swap:
            self.overtaken = data
            return
        self.sent = time.time_ns()
        self.send(data)
        if self.overtaken:
            self.send(self.overtaken)
            self.overtaken = b""
        if since in self.faults.twice:
            self.send(data)

    def send(self, data):
        try:
            self.socket.sendto(data, (self.config.address, self.config.port))
        except OSError:
            self.total["not_sent"] += 1

    def send_until(self, deadline):
        """Sleep until a deadline, and send what was held back when its time has come."""
        while self.outbox and self.outbox[0][0] < deadline:
            due, data = self.outbox.pop(0)
            CLOCK.sleep(max(due - CLOCK.monotonic(), 0.0))
            self.send(data)
        CLOCK.sleep(max(deadline - CLOCK.monotonic(), 0.0))

    def telegram(self, number):
        if self.given.generation == "KRC2" and not number:
            return b'<Rob Type="KUKA"></Rob>'
        pose = self.axes(self.pose + self.by_program(number))
        values = {
            "DEF_AIPos": ("AIPos", self.axes(self.sensors.shown(self.measured.position)) + self.unrest()),
            "DEF_ASPos": ("ASPos", pose),
            "DEF_MACur": ("MACur", self.current()),
            "DEF_EIPos": ("EIPos", [500.0, *[0.0] * 5]),
            "GearTorque.A1": ("GearTorque", self.sign * self.torque()),
        }
        body = '<RIst X="1368.8" Y="5.2" Z="876.6" A="-126.9" B="24.9" C="-28.3"/>' * (
            "DEF_RIst" in self.config.sends
        )
        body += "".join(self.element(*values[tag]) for tag in self.config.sends if tag in values)
        body += f'<Delay D="{self.context.delay}"/>' * ("DEF_Delay" in self.config.sends)
        body += f"<IPOC>{self.ipoc}</IPOC>"
        body = f'<Dat TaskType="b">{body}</Dat>' if self.given.nested else body
        return f'<Rob Type="KUKA">{body}</Rob>'.encode()

    def element(self, name, values):
        digits = self.given.precision if name in ("AIPos", "ASPos") else 4
        axis = "E" if name.startswith("E") else "A"
        inside = " ".join(f'{axis}{k + 1}="{value:.{digits}f}"' for k, value in enumerate(values))
        return f"<{name} {inside}/>"

    def current(self):
        return self.measured.current * (100.0 / self.given.i_max if self.given.i_max else 1.0)

    def torque(self):
        return np.linalg.solve(self.robot.to_motors, self.robot.drive_gain * self.measured.current)


def percentiles(values):
    if not values:
        return {}
    p50, p99, p999 = np.percentile(values, [50, 99, 99.9]) * 1e-3
    return {"p50": round(p50), "p99": round(p99), "p99.9": round(p999), "max": round(max(values) * 1e-3)}


def parser():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", required=True, help="RSI_EthernetConfig.xml")
    parser.add_argument("--robot", default="cobot")
    parser.add_argument("--start", type=numbers, help="pose of the axes [deg], with commas")
    parser.add_argument("--sign", type=numbers, help="1 or -1 an axis")
    parser.add_argument("--zero", type=numbers, help="joint's position where the axis shows zero [rad]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--bind", default="127.0.0.1", help="the controller's own address")
    parser.add_argument("--seconds", type=float, default=0.0)
    parser.add_argument("--fifo", type=int, default=0, metavar="PRIORITY")
    parser.add_argument("--generation", default="KRC4")
    parser.add_argument("--cycle", type=float, default=0.0)
    parser.add_argument("--nested", action="store_true", help="put all into <Dat>")
    parser.add_argument("--precision", type=int, default=4)
    parser.add_argument("--timeout", type=int, default=100, help="cycles")
    parser.add_argument("--axiscorr", type=float, default=5.0)
    parser.add_argument("--axiscorrmon", type=float, default=6.0)
    parser.add_argument("--i-max", type=float, default=0.0, help="send currents in percent of this [A]")
    parser.add_argument("--mode", default="absolute", choices=("absolute", "relative"), help="of RSI_ON")
    parser.add_argument("--linked", type=numbers, help="1 or 0 an axis: whether AXISCORR is given it")
    parser.add_argument("--exchange", default="", metavar="2:3", help="axes whose corrections are exchanged")
    parser.add_argument("--movecorr", type=float, default=0.0, help="RSI_MOVECORR comes so late [s]")
    parser.add_argument("--lag", type=int, default=0, help="cycles until a correction has an effect")
    parser.add_argument("--noise", type=float, default=0.0, help="standard deviation of positions [deg]")
    parser.add_argument("--swing", type=float, default=0.0, help="the program itself moves the arm [deg]")
    parser.add_argument(
        "--additive", type=int, default=-1, metavar="CYCLE", help="RELATIVE mode from then on"
    )
    parser.add_argument("--runs", type=timed, default={}, metavar="CYCLE:SPEED", help="axis 2 [deg/s]")
    parser.add_argument("--mute", type=int, default=-1, metavar="CYCLE", help="no telegram from then on")
    for name in ("drop", "duplicate", "reorder", "restart"):
        parser.add_argument(f"--{name}", default="", metavar="3,7-9", help="cycles")
    for name in ("delay", "stall", "jump"):
        parser.add_argument(f"--{name}", default="", metavar="CYCLE:NUMBER", help="seconds, or ms of IPOC")
    return parser


def numbers(text):
    return [float(part) for part in text.split(",")]


def main():
    given = parser().parse_args()
    terminated = []
    signal.signal(signal.SIGTERM, lambda *_: terminated.append(True))
    controller = Controller(given)
    keep_cycle(given.fifo)
    print("ready", *controller.socket.getsockname(), flush=True)
    end = CLOCK.monotonic() + given.seconds if given.seconds else float("inf")

    def ended(_=0, wait=0.0):
        line = sys.stdin.readline() if CLOCK.readable([sys.stdin], wait) else "\n"
        if line.strip():
            controller.sensors.told(line.split())
        return bool(not line or terminated) or CLOCK.monotonic() > end

    counts = controller.run(ended)
    controller.socket.close()
    while counts["stopped"] and not ended(wait=0.05):
        pass
    print(json.dumps(counts), flush=True)


if __name__ == "__main__":
    main()
