"""Each driver and the controller it is held against: a peer in a process of its own."""

import importlib.util
import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from exidyn.acquire.run.arms import make_driver
from exidyn.drivers import Driver
from exidyn.drivers.kuka_rsi.config import config_text, standard_config
from exidyn.identification.simulation.plant import typical_plant
from tests.peers.can_arm import canopen_settings, mit_settings
from tests.peers.peer_process import NoBus as NoBus
from tests.peers.peer_process import Peer
from tests.peers.servo_units import dynamixel_settings, feetech_settings
from tests.peers.ur_settings import ur_settings

from .run import FR3, MODEL, ROBOT, START

Peer.shared = False  # these runs are in real time
PRIORITY = 70
"""Of the peers, below the loop: a controller has a processor of its own, and these share ours."""
WINDOW = 360.0
"""Of the KUKA controller's corrections [deg]: wide, as for identification."""
FEETECH_CYCLE = 0.0025
"""What six servos need on a line of 1 Mbaud, in halves of a millisecond [s]."""
FRANKA_BUFFER = 0.03
"""Of commands [s]; the monitors of a run bear 0.05."""

CURRENT_RANGE = 40.0
"""Largest value in an answer of a MIT motor: twice the largest current of the arm [A]."""
MIT_MOTORS = ("--maker", "t-motor", "--torque-range", str(CURRENT_RANGE))


class Controlled(NamedTuple):
    """A driver that is not open yet, and the peer at its other end; the mock has none."""

    driver: Driver
    peer: Peer | None


@contextmanager
def mock(folder: Path, settings: Mapping[str, Any], arguments: tuple[str, ...]) -> Iterator[Controlled]:
    """The simulated arm on the host's own clock."""
    plant = lambda: typical_plant(MODEL, START)  # noqa: E731
    yield Controlled(make_driver("mock", {"clock": "real", **settings}, MODEL.robot, plant), None)


@contextmanager
def franka(folder: Path, settings: Mapping[str, Any], arguments: tuple[str, ...]) -> Iterator[Controlled]:
    """An FR3; the buffer is for a computer that has to simulate it too."""
    if importlib.util.find_spec("pylibfranka") is None or importlib.util.find_spec("franky_sim") is None:
        raise NoBus("pylibfranka or franky_sim is not installed")
    where = ",".join(map(str, FR3.start.tolist()))
    given = ("--robot", FR3.file, f"--start={where}", "--fifo", str(PRIORITY), *arguments)
    with Peer("franka_controller.py", *given, shared=False) as peer:
        table = {"address": peer.address, "buffer": FRANKA_BUFFER, **settings}
        yield Controlled(make_driver("franka", table, FR3.model.robot), peer)


@contextmanager
def kuka_rsi(folder: Path, settings: Mapping[str, Any], arguments: tuple[str, ...]) -> Iterator[Controlled]:
    """A KRC4 with a clock of 4 ms."""
    config = rsi_config(folder)
    given = {"controller": "127.0.0.1", "config": str(config), "wait": 20.0}
    given |= {"window_lower": -WINDOW, "window_upper": WINDOW, "overall": WINDOW, **settings}
    with krc(config, *arguments) as peer:
        yield Controlled(make_driver("kuka_rsi", given, MODEL.robot), peer)


def rsi_config(folder: Path) -> Path:
    """A configuration file that controller and driver share, with a port of its own."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    path = folder / "RSI_EthernetConfig.xml"
    path.write_text(config_text(standard_config("127.0.0.1", port)))
    return path


def krc(config: Path, *arguments: str) -> Peer:
    """A KUKA controller."""
    window = ("--axiscorr", f"{WINDOW:g}", "--axiscorrmon", f"{WINDOW:g}")
    given = ("--config", str(config), "--robot", ROBOT, "--fifo", str(PRIORITY), *window, *arguments)
    return Peer("krc.py", *given, shared=False)


def _on_a_bus(script: str, name: str, settings_of: Callable[..., dict[str, Any]], *always: str) -> Any:
    @contextmanager
    def controller(
        folder: Path, settings: Mapping[str, Any], arguments: tuple[str, ...]
    ) -> Iterator[Controlled]:
        with Peer(script, "--robot", ROBOT, *always, *arguments, shared=False) as peer:
            yield Controlled(make_driver(name, settings_of(peer.address) | settings, MODEL.robot), peer)

    return controller


def _mit(address: str) -> dict[str, Any]:
    """T-Motor's answer with a current; Damiao's have a torque, which shows nothing of the drive gains."""
    return mit_settings(address, maker="t-motor") | {"current_range": CURRENT_RANGE}


def _feetech(address: str) -> dict[str, Any]:
    return feetech_settings(address) | {"cycle": FEETECH_CYCLE}


CONTROLLERS: dict[str, Any] = {
    "mock": mock,
    "kuka_rsi": kuka_rsi,
    "ur_rtde": _on_a_bus("ur_controller.py", "ur_rtde", ur_settings, "--fifo", str(PRIORITY)),
    "franka": franka,
    "canopen_402": _on_a_bus("can_nodes.py", "canopen_402", canopen_settings, "--fifo"),
    "can_mit": _on_a_bus("mit_motors.py", "can_mit", _mit, "--fifo", *MIT_MOTORS),
    "dynamixel": _on_a_bus("dynamixel_bus.py", "dynamixel", dynamixel_settings),
    "feetech": _on_a_bus("feetech_bus.py", "feetech", _feetech, "--cycle", str(FEETECH_CYCLE)),
}


ARMS = {"franka": FR3}
"""Of drivers that move another arm than the cobot."""


def controller(name: str, folder: Path, *arguments: str, **settings: Any) -> Any:
    """A driver and its peer, as a context manager that gives a `Controlled`.

    `arguments` are more of the peer's command line, `settings` other ones of the driver than usual.
    """
    return CONTROLLERS[name](folder, settings, arguments)
