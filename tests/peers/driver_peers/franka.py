"""A Franka controller, where its simulator and the maker's library are installed."""

from ...parts.controllers.franka_controller import running
from . import DriverPeer

PEER = DriverPeer(
    lambda folder, *arguments: running(*arguments), joints=7, states="idle", powered=("motion",), cobot=None
)
