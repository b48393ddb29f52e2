"""Motors with the MIT frame on a CAN bus, one for each joint of a simulated arm.

    python tests/peers/mit_motors.py --robot cobot [--maker damiao|t-motor] [--short]

Prints "ready PORT", and later what happens. They are stiff, so that the arm is where its springs pull it to
without sag: what is tested is the wire. Faults are given as KIND:MOTOR@CYCLE, in cycles after all motors are
on: silent, error, runaway, noise. Ends when its standard input does.
"""

import struct

import numpy as np
from can_arm import MASTER, MIT_RANGES, sign, zero
from can_ends import frame
from can_nodes import CanPeer, arguments, emit, end_and_arm
from virtual_clock import of_this_peer

CLOCK = of_this_peer()
TIMEOUT_UNIT = 50e-6
RUNAWAY = 2.0
"""Speed of a joint whose motor no longer follows [rad/s]."""


RANGES = list(MIT_RANGES)
"""In the frames of these motors."""


class Motor:
    """One motor.

    With `short`, it answers in six bytes, as the older firmware of T-Motor.
    """

    def __init__(self, number, master, damiao, short):
        self.number, self.master, self.damiao, self.short = number, master, damiao, short
        self.position = self.velocity = self.torque = 0.0
        self.celsius = 25.0
        self.on, self.error = False, 0
        self.gains, self.wish = (100.0, 1.0), (0.0, 0.0)  # what the last host left
        self.received_at = CLOCK.monotonic()
        self.registers = {
            1: 0.945, 8: number, 7: master, 9: 0, 10: 2, 14: 5015, 20: 10.0,
            21: RANGES[0], 22: RANGES[1], 23: RANGES[2],
        }  # fmt: skip

    def received(self, data, now):
        """Take a command frame, and answer."""
        self.received_at = now
        special = data[7] if data[:7] == b"\xff" * 7 else None
        if special == 0xFC:
            self.switch(self.on or not self.error)
        elif special == 0xFD:
            self.switch(False)
        elif special == 0xFB:
            self.error = 0
        elif special is None:
            self.command(data)
        return self.answer()

    def switch(self, on):
        if on != self.on:
            emit(f"motor {self.number}: {'on' if on else 'off'}, gains {self.gains}")
        self.on = on

    def fail(self, error):
        self.error = error
        self.switch(False)
        emit(f"motor {self.number}: error {error}")

    def command(self, data):
        """Byte by byte, as the manuals draw it."""
        position = (data[0] << 8 | data[1]) / 65535.0
        velocity = (data[2] << 4 | data[3] >> 4) / 4095.0
        stiffness = ((data[3] & 15) << 8 | data[4]) / 4095.0
        damping = (data[5] << 4 | data[6] >> 4) / 4095.0
        self.wish = ((2.0 * position - 1.0) * RANGES[0], (2.0 * velocity - 1.0) * RANGES[1])
        self.gains = (500.0 * stiffness, 5.0 * damping)

    def answer(self):
        position = _whole(self.position, RANGES[0], 65535)
        velocity = _whole(self.velocity, RANGES[1], 4095)
        torque = _whole(self.torque, RANGES[2], 4095)
        shared = (velocity & 15) << 4 | torque >> 8
        body = bytes([position >> 8, position & 255, velocity >> 4, shared, torque & 255])
        if self.damiao:
            code = self.error or int(self.on)
            return bytes([self.number & 0x0F | code << 4]) + body + bytes([30, int(self.celsius)])
        tail = b"" if self.short else struct.pack("bB", int(self.celsius), self.error)
        return bytes([self.number]) + body + tail

    def asked(self, data):
        """The answer to a request to all; None where it is for another."""
        number, what, register = struct.unpack_from("<HBB", data)
        if number != self.number or not self.damiao:
            return None
        if what == 0xCC:
            return self.answer()
        if register not in self.registers:
            return None
        form = "<I" if register in (7, 8, 9, 10, 14) else "<f"
        if what == 0x55 and register in (9, 10):
            self.registers[register] = struct.unpack(form, data[4:])[0]
        elif what == 0xAA:
            emit(f"motor {self.number}: was ordered to store")
        return data[:4] + struct.pack(form, self.registers[register])

    def tick(self, now):
        patience = self.registers[9] * TIMEOUT_UNIT
        if self.damiao and self.on and patience and now - self.received_at > patience:
            self.fail(13)


def _whole(value, most, full):
    """The end of the scale for what has no value there, the lower one for what is no number."""
    value = -most if value != value else value
    return int(min(max((value / most + 1.0) * 0.5 * full + 0.5, 0.0), full))


class Motors(CanPeer):
    """All motors of an arm at one bus end, and the arm."""

    def __init__(self, end, plant, options):
        super().__init__(end, plant, options.fault)
        self.cycle, self.jumpy = options.cycle, options.jumpy
        joints = len(plant.joints)
        damiao = options.maker == "damiao"
        self.sign, self.zero = sign(joints), zero(joints)
        self.motors = [
            Motor(number, number + MASTER if damiao else 0, damiao, options.short)
            for number in range(1, joints + 1)
        ]
        self.silent, self.running = set(), set()
        self.asked = set()
        self.looked = CLOCK.monotonic()
        self.measure(1e-9 * CLOCK.host_time())
        self.held = self.plant.measure().position.copy()

    def measure(self, now):
        measured = self.plant.measure()
        for motor, position, velocity, current, celsius in zip(
            self.motors,
            (self.sensors.shown(self.pace.position(now)) - self.zero) * self.sign,
            measured.velocity * self.sign,
            measured.current * self.sign,
            measured.temperature,
            strict=True,
        ):
            motor.position, motor.velocity, motor.torque = position, velocity, current
            motor.celsius = celsius
            motor.position += 0.1 * (self.cycles % 2) * (motor.number == self.jumpy)

    def handle(self, message):
        if message.is_extended_id or message.is_remote_frame or len(message.data) != 8:
            return
        now, identifier, data = CLOCK.monotonic(), message.arbitration_id, bytes(message.data)
        if not self.asked:  # the first of a cycle; what all see is of that moment
            self.stamp = message.timestamp or 1e-9 * CLOCK.host_time()
            self.measure(self.stamp)
        if identifier == 0x7FF:
            motor = self.motors[data[0] - 1] if 0 < data[0] <= len(self.motors) else None
            answer = motor.asked(data) if motor else None
        elif 0 < identifier <= len(self.motors):
            motor = self.motors[identifier - 1]
            answer = motor.received(data, now)
        else:
            return
        if answer is not None:
            self.send(motor, answer)
            self.count(motor.number)

    def send(self, motor, answer):
        if motor.number not in self.silent:
            self.end.send(frame(motor.master, answer))

    def count(self, number):
        """A cycle is over when everybody was asked; then the arm moves to where it will be at the next."""
        self.asked.add(number)
        if len(self.asked) < len(self.motors):
            return
        self.asked.clear()
        self.cycles += 1
        if not self.on_at and all(motor.on for motor in self.motors):
            self.on_at = self.cycles
        self.move()
        self.go_wrong([motor.master for motor in self.motors])

    def move(self):
        """The arm goes where stiff springs pull it; what is off stays where it is."""
        for joint, motor in enumerate(self.motors):
            if motor.on and motor.gains[0] > 0.0 and motor.number not in self.running:
                self.held[joint] = motor.wish[0] * self.sign[joint] + self.zero[joint]
        for number in self.running:
            self.held[number - 1] += RUNAWAY * self.cycle if self.motors[number - 1].on else 0.0
        velocity = [motor.wish[1] if motor.on and motor.gains[0] > 0.0 else 0.0 for motor in self.motors]
        seconds = self.pace.length(self.cycle, self.stamp)
        self.pace.step(self.held, np.array(velocity) * self.sign, seconds)

    def let_go_wrong(self, kind, number):
        emit(f"motor {number}: now {kind}")
        if kind == "silent":
            self.silent.add(number)
        elif kind == "runaway":
            self.running.add(number)
        elif kind == "error":
            self.motors[number - 1].fail(10)

    def pass_time(self):
        now = CLOCK.monotonic()
        if now > self.looked + 0.002:
            self.looked = now
            for motor in self.motors:
                motor.tick(now)


def main():
    parser = arguments(__doc__.splitlines()[0])
    parser.add_argument("--maker", choices=("damiao", "t-motor"), default="damiao")
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--cycle", type=float, default=0.002)
    parser.add_argument("--register", action="append", default=[], help="MOTOR:NUMBER=VALUE")
    parser.add_argument("--on", action="store_true", help="all were left on, and hold where they stand")
    parser.add_argument("--jumpy", type=int, default=0, metavar="MOTOR", help="its encoder jumps to and fro")
    parser.add_argument("--error", type=int, default=0, help="all begin with this error")
    parser.add_argument("--torque-range", type=float, default=MIT_RANGES[2], help="or current, for T-Motor")
    options = parser.parse_args()
    RANGES[2] = options.torque_range
    motors = Motors(*end_and_arm(options), options)
    for text in options.register:
        place, _, value = text.partition("=")
        number, register = map(int, place.split(":"))
        registers = motors.motors[number - 1].registers
        registers[register] = type(registers[register])(value)
    for motor in motors.motors:
        motor.error = options.error
        motor.on, motor.wish = options.on, (motor.position, 0.0)
    motors.serve(options)


if __name__ == "__main__":
    main()
