"""The choice: what ends a study, and which run comes next."""

from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.belief.open_items import Item
from exidyn.trajectories.next_run import choice
from exidyn.trajectories.next_run.choice import DECIDED, OUT_OF_TIME, RUN, UNDECIDABLE, Forecast, choose

OPEN, SETTLED = Item("spring or weight", 0.6, True), Item("friction", 0.1, False)


def of(name, left, hour=None, seconds=10.0):
    """A forecast of a run with the entropy that it leaves of both items."""
    left, hour = np.array(left), np.array(left if hour is None else hour)
    return Forecast(SimpleNamespace(name=name, seconds=seconds, motion=seconds), left, hour, 0.6 - left[0])


@pytest.fixture
def chosen(monkeypatch):
    def make(found, items=(OPEN, SETTLED), seconds=60.0, **more):
        found = sorted(found, key=lambda one: -one.rate)
        monkeypatch.setattr(choice, "forecasts", lambda *_: found)
        monkeypatch.setattr(choice, "items", lambda _: list(items))
        return choose(None, [], [], seconds, **more)

    return make


def test_the_run_that_gains_most_per_second_comes_next(chosen):
    made = chosen([of("long", [0.1, 0.1], seconds=50.0), of("short", [0.3, 0.1])])
    assert made.verdict == RUN
    assert made.chosen.offer.name == "short"


def test_what_nothing_on_offer_settles_in_an_hour_is_undecidable_and_named(chosen):
    made = chosen([of("any", [0.6, 0.0], hour=[0.599, 0.0])])
    assert made.verdict == UNDECIDABLE
    assert made.remains == (OPEN,)
    assert made.chosen is None


def test_no_run_on_offer_leaves_what_is_open_undecidable(chosen):
    assert chosen([]).verdict == UNDECIDABLE


def test_all_settled_is_decided_though_runs_are_on_offer(chosen):
    items = (OPEN._replace(open=False), SETTLED)
    assert chosen([of("most", [0.2, 0.1])], items).verdict == DECIDED


def test_what_no_run_decides_does_not_keep_one_from_being_made_for_what_can_be_decided(chosen):
    both = (OPEN, OPEN._replace(words="masses"))
    made = chosen([of("neither", [0.59, 0.59], seconds=1.0), of("one", [0.6, 0.1])], both)
    assert made.verdict == RUN
    assert made.chosen.offer.name == "one"


def test_what_no_effect_explains_is_not_decided(chosen):
    items = (OPEN._replace(open=False), SETTLED)
    assert chosen([of("any", [0.5, 0.1])], items, unexplained=True).verdict == UNDECIDABLE


def test_a_run_that_takes_longer_than_is_left_is_not_begun(chosen):
    assert chosen([of("short", [0.1, 0.1])], seconds=5.0).verdict == OUT_OF_TIME


def test_a_run_for_which_there_is_time_comes_before_a_better_one(chosen):
    made = chosen([of("long", [0.0, 0.1], seconds=70.0), of("short", [0.5, 0.1])])
    assert made.chosen.offer.name == "short"


def test_a_run_that_settles_what_is_settled_already_is_not_worth_while(chosen):
    cheap = of("cheap", [0.595, 0.0], seconds=0.01)
    made = chosen([cheap, of("telling", [0.1, 0.1])])
    assert made.chosen.offer.name == "telling"
