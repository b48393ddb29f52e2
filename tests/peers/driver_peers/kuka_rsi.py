"""A KUKA controller."""

from contextlib import contextmanager

from ...parts.controllers import rsi_controller
from . import DriverPeer

POSE = (0.0, -126.0, -64.0, -72.0, -72.0, -72.0)
"""Where the cobot's axes stand [deg]: gravity pulls at the second and third."""


@contextmanager
def running(folder, *arguments):
    path = rsi_controller.config_file(folder)
    with rsi_controller.running(path, "--timeout", 500, *arguments) as process:
        yield process, {"controller": "127.0.0.1", "config": str(path), "wait": 20.0, "timeout": 500}


def is_off(process, samples):
    counts = rsi_controller.counted(process)
    return counts["answered"] > samples and counts["farthest"] == 0.0


PEER = DriverPeer(
    running,
    states="",
    is_off=is_off,
    hasty={"wait": 0.2},
    cobot=("--start", ",".join(map(str, POSE))),
    pose=POSE,
)
