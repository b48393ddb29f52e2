"""Short recordings, and no compiler."""

import os

import pytest

os.environ["NUMBA_DISABLE_JIT"] = "1"  # small arms and short runs do not pay for compiling

from parts.concealed.plant import closed_loop as concealed_plant
from parts.concealed.recordings import record as concealed_record

from .robots import swing


@pytest.fixture
def at_once(monkeypatch):
    """Recordings of a tenth of a second, drives not settled before."""
    monkeypatch.setattr(concealed_plant, "SETTLE", 0.01)
    monkeypatch.setattr(concealed_record, "SETTLE", 0.01)
    monkeypatch.setattr(concealed_record, "path_of", lambda *_: swing(2, 0.1))
