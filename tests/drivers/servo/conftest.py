"""Servos of the tests in this folder, as processes that live as long as the tests of a file."""

from contextlib import ExitStack
from functools import cache

import pytest

from ...parts.controllers.servo_parts import HELD, peer, send_only


@pytest.fixture(scope="module")
def processes():
    """Function that starts a peer of a kind, once for each of its command lines."""
    with ExitStack() as stack:
        yield cache(lambda kind, *arguments: stack.enter_context(peer(kind, *arguments)))


@pytest.fixture
def servos(processes, kind):
    """An arm held by its servos, which answer at once, with all other registers as from the factory."""
    arguments, registers = HELD[kind]
    process = processes(kind, *arguments)
    for line in ("heal", *registers):
        send_only(process, line)
    return process


@pytest.fixture
def mirrors(processes, kind):
    """Servos that are where they were commanded last."""
    process = processes(kind, "--mirror")
    send_only(process, "heal")
    return process
