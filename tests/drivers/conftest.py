"""Drivers in these tests run by a virtual clock."""

import pytest

from exidyn.drivers.driver import Driver

from ..peers.virtual_clock import of_this_test


@pytest.fixture(autouse=True)
def clock(monkeypatch):
    """The clock of drivers and their peers."""
    monkeypatch.setattr(Driver, "clock", of_this_test())
    return Driver.clock
