"""What tests of formats share."""

from importlib import import_module

import pytest

from exidyn.identification.recordings import reading_limits


@pytest.fixture
def in_process(monkeypatch):
    """Readers run in this process: one of their own takes 0.3 s a file, and other tests start it."""

    def call(place, arguments, memory, seconds):
        module, name = place.split(":")
        return getattr(import_module(module), name)(*arguments)

    monkeypatch.setattr(reading_limits, "call", call)
