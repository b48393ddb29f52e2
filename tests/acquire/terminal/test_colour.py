"""Color is for people at a terminal: none in pipes, and none where it is not wanted."""

import io
import re

import pytest

from exidyn.acquire.terminal.json_output import colored

PAGE = f"""Verdict
{"-" * 80}
- More than noise is left on joint2 (8.7 x noise).
- Nothing is missing on joint3.
gravity  86.93 N m  right
slope    12.10 N m  wrong"""


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture(autouse=True)
def _environment(monkeypatch):
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")


def test_a_terminal_gets_headings_bold_and_what_is_wrong_red():
    shown = colored(PAGE, Terminal())
    assert "\x1b[1mVerdict\x1b[0m\n" in shown
    assert "\x1b[31mMore than noise is left on joint2\x1b[0m" in shown
    assert "\x1b[32mNothing is missing\x1b[0m on joint3" in shown
    assert "\x1b[32mright\x1b[0m\n" in shown
    assert shown.endswith("\x1b[31mwrong\x1b[0m")
    assert re.sub(r"\x1b\[\d*m", "", shown) == PAGE


@pytest.mark.parametrize(("name", "value"), [("NO_COLOR", "1"), ("TERM", "dumb")])
def test_who_wants_none_gets_none(monkeypatch, name, value):
    monkeypatch.setenv(name, value)
    assert colored(PAGE, Terminal()) == colored(PAGE, io.StringIO()) == PAGE  # nor does a pipe
