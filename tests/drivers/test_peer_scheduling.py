"""Peers ask for real-time scheduling, and do without it where it is refused."""

import pytest

from ..peers import served


@pytest.mark.parametrize(
    ("fifo", "refusal", "printed"), [(70, PermissionError, "no real-time scheduling\n"), (0, None, "")]
)
def test_a_peer_runs_without_real_time_scheduling_too(fifo, refusal, printed, capsys, monkeypatch):
    def refuse(*_):
        raise refusal

    monkeypatch.setattr(served.os, "sched_setscheduler", refuse)
    done = []
    for name in ("freeze", "disable"):
        monkeypatch.setattr(served.gc, name, lambda name=name: done.append(name))
    served.keep_cycle(fifo)
    assert capsys.readouterr().out == printed
    assert done == ["freeze", "disable"]
