"""Which transport an interface has."""

import os
import socket
from collections.abc import Mapping
from typing import Any

import can

from .slcan import SlcanTransport
from .socketcan import SocketcanTransport
from .transport import PythonCanTransport, Transport


def transport_of(bus: can.BusABC, interface: str, channel: str, options: Mapping[str, Any]) -> Transport:
    """The quickest transport that an open bus allows.

    Args:
        bus: Of python-can.
        interface: As python-can names it.
        channel: As that interface names it.
        options: With which the bus was opened.
    """
    link = getattr(bus, "socket", None)
    if interface == "socketcan" and channel and isinstance(link, socket.socket):
        return SocketcanTransport(link)
    if interface == "slcan" and hasattr(port := getattr(bus, "serialPortOrig", None), "fd"):
        return SlcanTransport(port)
    if interface == "udp_multicast" and os.name == "posix":
        from .udp_multicast import UdpMulticastTransport  # needs msgpack, which no other interface does

        return UdpMulticastTransport(bus.fileno(), channel, options.get("port"))
    return PythonCanTransport(bus)
