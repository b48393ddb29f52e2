"""Announcer: what a person must know is printed beside the loop, also that the loop is blocked."""

import threading
import time

import pytest

from exidyn.acquire.run import announcer
from exidyn.acquire.run.announcer import Announcer

pytestmark = pytest.mark.clocked(patient=True)

PATIENCE = 30.0


class Terminal:
    """Keeps what it is shown; may be stopped."""

    def __init__(self):
        self.texts, self.goes_on = [], threading.Event()
        self.goes_on.set()

    def show(self, text):
        self.goes_on.wait(PATIENCE)
        self.texts.append(text)

    def wait_for(self, text):
        end = time.monotonic() + PATIENCE
        while text not in self.texts and time.monotonic() < end:
            time.sleep(0.005)
        return text in self.texts


def test_texts_come_in_their_order_and_the_last_ones_before_it_ends():
    terminal = Terminal()
    with Announcer(terminal.show, "blocked") as said:
        for number in range(5):
            said.say(f"text {number}")
    assert terminal.texts == [f"text {number}" for number in range(5)]


def test_a_terminal_that_was_stopped_holds_up_nobody(monkeypatch):
    monkeypatch.setattr(announcer, "FINISH", 0.01)
    terminal = Terminal()
    terminal.goes_on.clear()
    with Announcer(terminal.show, "blocked") as said:
        said.say("first")
        said.say("second")
    assert terminal.texts == []
    terminal.goes_on.set()
    assert terminal.wait_for("second")


def test_a_loop_that_does_not_come_round_is_told_once(monkeypatch):
    monkeypatch.setattr(announcer, "BLOCKED", 0.01)
    monkeypatch.setattr(announcer, "LOOK", 0.01)
    terminal = Terminal()
    with Announcer(terminal.show, "blocked") as said:
        said.begin_cycle()
        assert terminal.wait_for("blocked")
    assert terminal.texts == ["blocked"]


def test_no_loop_is_blocked_before_it_begins_or_after_it_has_ended(monkeypatch):
    monkeypatch.setattr(announcer, "BLOCKED", 0.0)
    monkeypatch.setattr(announcer, "LOOK", 0.001)
    terminal = Terminal()
    with Announcer(terminal.show, "blocked") as said:
        said.say("before")
        terminal.wait_for("before")
        said.stop_watching()
        said.say("after")
        terminal.wait_for("after")
        time.sleep(0.05)
    assert terminal.texts == ["before", "after"]
