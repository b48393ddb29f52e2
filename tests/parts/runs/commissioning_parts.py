"""Commands on a peer: its controller file, and their output as JSON."""

import json
from contextlib import contextmanager

from exidyn.acquire.command_line import main
from exidyn.acquire.run.stopping.watch import WatchLimits

from ...peers.can_arm import canopen_settings, mit_settings
from ...peers.peer_process import Peer
from ...peers.ur_settings import ur_settings
from ..controllers import rsi_controller, servo_parts
from ..controllers.can_peers import peer as can_peer

PATIENT = WatchLimits(silence=2.0, stall=2.0, missed=0.9)
"""Monitors that do not mind a computer which is busy with other things; all others are as usual."""
POSE = (0.0, -126.0, -64.0, -72.0, -72.0, -72.0)
"""Where a KUKA's axes stand [deg]: gravity pulls at the second and third."""


def controller_file(folder, driver, settings):
    """Written; its path."""
    lines = [f'driver = "{driver}"', "[settings]", *(f"{k} = {json.dumps(v)}" for k, v in settings.items())]
    path = folder / f"{driver}.toml"
    path.write_text("\n".join(lines))
    return path


@contextmanager
def kuka_rsi(folder, **settings):
    """A KUKA cobot, and the path of its controller file."""
    config = rsi_controller.config_file(folder)
    start = ",".join(map(str, POSE))
    given = {"controller": "127.0.0.1", "config": str(config), "wait": 20.0, "timeout": 500} | settings
    with rsi_controller.running(config, "--timeout", 500, "--start", start) as peer:
        yield peer, controller_file(folder, "kuka_rsi", given)


@contextmanager
def ur_rtde(folder, **settings):
    with Peer("ur_controller.py", "--series", "cb3") as peer:
        given = ur_settings(peer.address) | {"cycle": 0.008, "dead_man": 2.0} | settings
        yield peer, controller_file(folder, "ur_rtde", given)


@contextmanager
def canopen_402(folder, **settings):
    with can_peer("can_nodes.py", "--robot", "cobot", "--lockstep") as peer:
        given = canopen_settings(peer.address) | {"cycle": 0.01, "dead_man": 2.0, "heartbeat": 1.0} | settings
        yield peer, controller_file(folder, "canopen_402", given)


@contextmanager
def can_mit(folder, **settings):
    with can_peer("mit_motors.py", "--robot", "cobot", "--lockstep", "--cycle", 0.01) as peer:
        given = mit_settings(peer.address) | {"cycle": 0.01, "dead_man": 2.0} | settings
        yield peer, controller_file(folder, "can_mit", given)


@contextmanager
def dynamixel(folder, **settings):
    with servo_parts.peer("dynamixel", "--lockstep", "--cycle", 0.01) as peer:
        given = servo_parts.SETTINGS["dynamixel"](peer.address) | {"watchdog": 2.0, "cycle": 0.01} | settings
        yield peer, controller_file(folder, "dynamixel", given)


@contextmanager
def feetech(folder, **settings):
    with servo_parts.peer("feetech", "--lockstep", "--cycle", 0.01) as peer:
        given = servo_parts.SETTINGS["feetech"](peer.address) | {"cycle": 0.01} | settings
        yield peer, controller_file(folder, "feetech", given)


CELLS = {one.__name__: one for one in (kuka_rsi, ur_rtde, canopen_402, can_mit, dynamixel, feetech)}


def verdicts(text):
    """Name -> verdict of the judgements of a jog."""
    return {one["name"]: one["verdict"] for one in text["judgements"]}


def jog(capsys, *arguments):
    """Exit code, and the output of a jog of the cobot."""
    code = main(["jog", "--robot", "cobot", "--json", "-", *map(str, arguments)])
    return code, json.loads(capsys.readouterr().out)


def jog_on(cell, folder, capsys, *arguments, **settings):
    """As `jog`, on a peer, which is given as well."""
    with cell(folder, **settings) as (peer, path):
        code, text = jog(capsys, "--controller", path, "--yes", *arguments)
    return code, text, peer
