"""Settings, the program that the controller runs with them, and how to send it.

The program follows registers of RTDE by `servoj`, and stops by itself.
"""

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from ..errors import BadSettings, LinkLost
from ..settings import setting


@dataclass(frozen=True)
class UrSettings:
    """Settings of a Universal Robots controller."""

    address: str = setting(..., "address of the controller, such as 192.168.56.101")
    cycle: float = setting(
        0.002, "time between commands; at least 0.002, on a CB3 0.008", unit="s", low=0.002, high=0.1
    )
    lookahead: float = setting(
        0.03, "time over which servoj smooths; most of its latency", unit="s", low=0.03, high=0.2
    )
    gain: float = setting(300.0, "gain of servoj", low=100.0, high=2000.0)
    deceleration: float = setting(
        10.0, "deceleration of the program's stops (stopj)", unit="rad/s^2", low=0.1, high=100.0
    )
    dead_man: float = setting(
        0.2, "time without a command after which the program stops by itself", unit="s", low=0.01, high=10.0
    )
    first_register: int = setting(
        24, "first register that is used: 0 if a fieldbus uses registers from 24 on", choices=(0, 24)
    )
    wait: float = setting(
        5.0, "time to wait for an answer, and for the program to begin", unit="s", low=0.1, high=60.0
    )
    rtde_port: int = setting(30004, "port of RTDE", low=1, high=65535)
    program_port: int = setting(30002, "port that programs are sent to", low=1, high=65535)
    dashboard_port: int = setting(29999, "port of the dashboard server", low=1, high=65535)


def require_cycle(cycle: float, major: int) -> None:
    """Raise BadSettings if a controller with this major version does not support the cycle [s]."""
    series, base = ("CB3", 0.008) if major <= 3 else ("e-Series or later", 0.002)
    if cycle < base - 1e-9 or abs(cycle / base - round(cycle / base)) > 1e-6:
        raise BadSettings(
            f"driver ur_rtde: cycle is {cycle:g} s, but the controller has version {major} ({series}), whose "
            f"cycle is {base:g} s. Try cycle = {base:g}, or a multiple"
        )


FOLLOW, STOP = 1, 2
"""Demand to the program, in the second integer register."""
RUNNING, ASKED, SILENT = 0, 1, 2
"""State of the program, or why it has ended, in the second register that it writes."""
JOINTS = 6

PROGRAM = """\
def exidyn():
  write_output_integer_register({ended}, {RUNNING})
  write_output_integer_register({session_register}, {session})
  last = 0
  silent = 0
  why = {RUNNING}
  while why == {RUNNING}:
    count = read_input_integer_register({count})
    if count == last:
      silent = silent + 1
    else:
      silent = 0
      last = count
    end
    if read_input_integer_register({demand}) != {FOLLOW}:
      why = {ASKED}
    elif silent > {patience}:
      why = {SILENT}
    else:
      q = [{registers}]
      servoj(q, 0, 0, {cycle:g}, {lookahead:g}, {gain:g})
    end
  end
  write_output_integer_register({ended}, why)
  stopj({deceleration:g})
end
"""


class Registers:
    """Names of the registers that the driver and its program share, from a first number on."""

    def __init__(self, first: int) -> None:
        self.first = first
        self.position = [f"input_double_register_{first + joint}" for joint in range(JOINTS)]
        self.count, self.demand = f"input_int_register_{first}", f"input_int_register_{first + 1}"
        self.session, self.ended = f"output_int_register_{first}", f"output_int_register_{first + 1}"

    @property
    def inputs(self) -> list[str]:
        return [*self.position, self.count, self.demand]


def program_text(settings: UrSettings, session: int) -> str:
    """Text of the program, which writes the number of its session once it runs."""
    first = settings.first_register
    return PROGRAM.format(
        RUNNING=RUNNING,
        ASKED=ASKED,
        SILENT=SILENT,
        FOLLOW=FOLLOW,
        session_register=first,
        ended=first + 1,
        session=session,
        count=first,
        demand=first + 1,
        registers=", ".join(f"read_input_float_register({first + joint})" for joint in range(JOINTS)),
        patience=round(settings.dead_man / settings.cycle),
        cycle=settings.cycle,
        lookahead=settings.lookahead,
        gain=settings.gain,
        deceleration=settings.deceleration,
    )


@contextmanager
def program_sent(address: str, port: int, text: str, patience: float) -> Iterator[None]:
    """Send the controller a program, which it begins at once if it accepts programs from this computer.

    The connection stays open during the block, because a program may be lost if it is closed at once. Raises
    LinkLost without a connection.
    """
    try:
        link = socket.create_connection((address, port), patience)
        link.sendall(text.encode())
    except OSError as error:
        raise LinkLost(
            f"driver ur_rtde: no program could be sent to {address}:{port}: {error.strerror or error}. Try, "
            "on the pendant, Settings, Security, Services: Secondary Client must be enabled"
        ) from error
    with link:
        yield
