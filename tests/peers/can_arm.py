"""How the drives on CAN count: what the peers have and their host must know."""

import socket
from types import SimpleNamespace

import numpy as np

CHANNEL = "ff11:7079:7468:6f6e:6465:6d6f:6d63:6173"
"""Interface-local scope: no frame leaves the machine."""


def free_port():
    """A UDP port of this test's own, so that parallel ones do not meet."""
    with socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as probe:
        probe.bind(("::", 0))
        return probe.getsockname()[1]


def multicast(port):
    """A python-can bus on that port."""
    import can

    return can.Bus(channel=CHANNEL, interface="udp_multicast", port=port, fd=False, ignore_config=True)


COUNTS, GEAR = 131072, 101.0
"""Counts a revolution of the motor, and revolutions of it a revolution of the joint."""


class ObedientArm:
    """Six joints that are at once where they are commanded; their currents identify their joint."""

    joints = tuple(f"joint{number}" for number in range(1, 7))

    def __init__(self):
        self.position, self.velocity = np.array([0.0, -1.0, 1.0, 0.0, 0.5, 0.0]), np.zeros(6)

    def measure(self):
        return SimpleNamespace(
            position=self.position,
            velocity=self.velocity,
            current=0.1 * np.arange(1, 7),
            temperature=np.full(6, 25.0),
        )

    def step(self, position, velocity, seconds):
        self.position, self.velocity = np.array(position), np.array(velocity)


def make_arm(robot, start=None, seed=0):
    """The obedient arm, or a simulated one, whose import takes a while."""
    if robot == "obedient":
        return ObedientArm()
    from arm import make_plant

    return make_plant(robot, start, seed)


def sign(joints):
    """Every second drive counts the other way, shape (n,)."""
    return np.where(np.arange(joints) % 2, -1.0, 1.0)


def zero(joints):
    """Where joints are when their drives count zero, shape (n,) [rad]."""
    return 0.05 * (1.0 + np.arange(joints))


DEAD_MAN = 2.0
"""Silence of the host after which drives stop [s]: processes on a busy machine stall for half a second."""


def bus_settings(address):
    """How a driver reaches the bus of a peer that text this address."""
    if address.startswith("/"):
        return {"interface": "slcan", "channel": address, "options": "sleep_after_open=0"}
    return {"interface": "udp_multicast", "channel": CHANNEL, "options": f"port={address}, fd=false"}


def canopen_settings(address, joints=6):
    """Settings of driver canopen_402 for the drives of `can_nodes.py`."""
    return {
        **bus_settings(address),
        "nodes": list(range(1, joints + 1)),
        "counts": COUNTS,
        "gear": GEAR,
        "sign": [int(one) for one in sign(joints)],
        "zero": [float(one) for one in zero(joints)],
        "dead_man": DEAD_MAN,
        "heartbeat": 1.0,  # a drive counts as lost after 3.5 of them
    }


MASTER = 16
"""By how much identifiers of answers are above those of commands."""
MIT_RANGES = (12.5, 30.0, 10.0)
"""Largest position [rad], velocity [rad/s] and torque [N m] in frames of the motors."""


def mit_settings(address, joints=6, maker="damiao"):
    """Settings of driver can_mit for the motors of `mit_motors.py`."""
    position, velocity, torque = MIT_RANGES
    damiao = maker == "damiao"
    return {
        **bus_settings(address),
        "model": "DM4310" if damiao else "T-Motor",
        "ids": list(range(1, joints + 1)),
        "masters": [number + MASTER if damiao else 0 for number in range(1, joints + 1)],
        "position_range": position,
        "velocity_range": velocity,
        "torque_range": torque,
        "kp": 200.0,
        "kd": 3.0,
        "sign": [int(one) for one in sign(joints)],
        "zero": [float(one) for one in zero(joints)],
        "dead_man": DEAD_MAN,
    }
