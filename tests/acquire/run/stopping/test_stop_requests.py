import os
import signal

import pytest

from exidyn.acquire.run.stopping.stop import StopRequests
from exidyn.drivers import StopLevel

pytestmark = pytest.mark.clocked


def test_the_first_brakes_the_second_stops_quickly():
    with StopRequests() as asked:
        assert asked.look() is None
        os.kill(os.getpid(), signal.SIGINT)
        assert asked.stop.level == StopLevel.BRAKE
        os.kill(os.getpid(), signal.SIGINT)
        assert asked.stop.level == StopLevel.QUICK


def test_asked_to_end_it_brakes_however_often():
    with StopRequests() as asked:
        asked.look()
        os.kill(os.getpid(), signal.SIGTERM)
        os.kill(os.getpid(), signal.SIGTERM)
        assert asked.stop.level == StopLevel.BRAKE


def test_afterwards_signals_are_what_they_were():
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with StopRequests():
        pass
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


@pytest.fixture
def hangup():
    """What the terminal that the tests run in does on hang-ups; it may be none."""
    before = signal.getsignal(signal.SIGHUP)
    yield lambda handler: signal.signal(signal.SIGHUP, handler)
    signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize("handler", [signal.SIG_DFL, signal.SIG_IGN])
def test_a_terminal_that_goes_away_brakes_unless_it_was_to_be_outlived(hangup, handler):
    hangup(handler)
    with StopRequests() as asked:
        asked.look()
        os.kill(os.getpid(), signal.SIGHUP)
        assert (asked.stop and asked.stop.level) == (StopLevel.BRAKE if handler == signal.SIG_DFL else None)


def test_before_anybody_looks_the_first_interrupts_and_the_way_out_is_not_interrupted():
    with StopRequests() as asked:
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGTERM)
        os.kill(os.getpid(), signal.SIGINT)
        assert asked.stop.level == StopLevel.QUICK
