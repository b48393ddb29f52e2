"""Which telegram is the next one."""

import pytest

from exidyn.drivers.kuka_rsi.session import JUMP, Datagram, Session
from exidyn.drivers.kuka_rsi.telegram import TelegramReader

from ...parts.controllers.rsi_controller import telegram


def session():
    return Session(TelegramReader(["AIPos.A1"]), 4)


def datagram(stamp, port=1000, arrival=None):
    return Datagram(telegram(stamp), port, 1_000_000 * stamp if arrival is None else arrival)


def test_the_newest_counts_and_missing_ones_are_counted():
    one = session()
    assert one.take([datagram(100)]).cycles == 1
    assert one.take([datagram(104)]).cycles == 1
    assert one.take([]) is None
    fresh = one.take([datagram(108), datagram(112), datagram(116)])
    assert (fresh.telegram.time, fresh.cycles) == (116, 3)
    assert one.take([datagram(136)]).cycles == 5
    assert one.elapsed == 36
    assert one.events() == ()


def test_telegrams_that_come_twice_late_or_broken_are_reported_once():
    one = session()
    one.take([datagram(100), datagram(104)])
    assert one.take([datagram(104), datagram(104), datagram(100), Datagram(b"?", 1000, 0)]) is None
    assert one.events() == (
        "2 telegrams came twice",
        "1 telegram came too late",
        "1 telegram could not be read",
    )
    assert one.events() == ()
    assert one.unread.data == b"?"
    assert one.take([datagram(112), datagram(108)]).telegram.time == 112
    assert one.events() == ("1 telegram came too late",)


def test_lateness_is_against_the_stamps():
    one = session()
    one.take([datagram(100)])
    assert abs(one.take([datagram(104, arrival=110_500_000)]).late - 0.0065) < 1e-12
    assert abs(one.take([datagram(112, arrival=112_000_000)]).late + 0.0065) < 1e-12


def test_the_clock_may_turn_over():
    one = session()
    one.take([datagram((1 << 32) - 8)])
    assert one.take([datagram(4)]).cycles == 3
    assert one.restarted == ""


def test_a_jump_either_way_or_another_port_is_another_session():
    for other in (datagram(100_000 + 4 * JUMP), datagram(100_000 - 4 * JUMP), datagram(100_004, port=2)):
        one = session()
        one.take([datagram(100_000)])
        fresh = one.take([other])
        assert fresh.cycles == 1
        assert "has begun a new RSI session" in one.restarted
        before = one.restarted
        assert (
            one.take([Datagram(telegram(other.data and fresh.telegram.time + 4), other.port, 0)]).cycles == 1
        )
        assert one.restarted == before
        assert one.elapsed == 8


def test_who_sends_one_telegram_again_for_a_while_waits_for_an_answer():
    one = session()
    one.take([datagram(100, arrival=0)])
    one.take([datagram(100, arrival=1000 * number) for number in range(1, 5)])
    assert not one.waits  # a network that doubles telegrams does it at once
    one.take([datagram(100, arrival=60_000_000)])
    assert one.waits
    one.take([datagram(104, arrival=61_000_000)])
    assert not one.waits


def test_stamps_that_count_answers_show_nothing_of_time():
    one = session()
    one.take([datagram(0, arrival=0), datagram(0, arrival=10**9)])
    one.count_answers()
    assert one.events() == ()
    fresh = one.take([datagram(1, arrival=10**9 + 7_000_000)])
    assert (fresh.cycles, fresh.late) == (1, 0.0)
    assert one.take([datagram(4, arrival=10**9 + 9_000_000)]).cycles == 3
    assert one.elapsed == pytest.approx(1009.0)
