import io

import pytest

from exidyn.acquire.run.errors import NotAllowed, NotConfirmed
from exidyn.acquire.terminal.run_summary import UNATTENDED, confirm

pytestmark = pytest.mark.clocked


def test_nobody_is_asked_for_a_simulation_and_yes_is_yes(monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    confirm(simulated=True, yes=False)
    with pytest.raises(NotConfirmed, match="there is no terminal to type yes in"):
        confirm(simulated=False, yes=False)
    monkeypatch.setattr("sys.stdin", io.StringIO("yes\n"))
    confirm(simulated=False, yes=False)
    assert "not safety-rated" in capsys.readouterr().err


@pytest.mark.parametrize("answer", ["", "y\n", "YES\n", "no\n", "\n", "yes please\n"])
def test_anything_but_yes_is_no(monkeypatch, answer):
    monkeypatch.setattr("sys.stdin", io.StringIO(answer))
    with pytest.raises(NotConfirmed):
        confirm(simulated=False, yes=False)


def test_a_flag_alone_moves_nothing(monkeypatch):
    monkeypatch.delenv(UNATTENDED, raising=False)
    with pytest.raises(NotAllowed, match=UNATTENDED):
        confirm(simulated=False, yes=True)
    monkeypatch.setenv(UNATTENDED, "yes")
    confirm(simulated=False, yes=True)
