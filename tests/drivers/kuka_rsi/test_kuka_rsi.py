"""The KUKA driver, against a controller by hand and one that runs as a process."""

import logging
import re
import socket
from itertools import pairwise

import numpy as np
import pytest

from exidyn.drivers import Command, Driver, StopLevel
from exidyn.drivers.errors import BadSettings, LinkLost, NotReady
from exidyn.drivers.host_clock import HOST

from ...parts.controllers.rsi_controller import (
    START,
    by_hand,
    command,
    config_file,
    correction,
    counted,
    driver,
    running,
    telegram,
)


@pytest.fixture
def path(tmp_path):
    return config_file(tmp_path)


@pytest.mark.parametrize("real", [False, True])
def test_each_telegram_is_answered_with_the_command_of_its_cycle(path, real, monkeypatch):
    if real:
        monkeypatch.setattr(Driver, "clock", HOST)
    with by_hand(path) as controller, driver(path) as one:
        _, first = controller.begun(one)
        for number in range(1, 6):
            position = START + 0.01 * np.array([number, 0, -number, 0, 0, number])
            stamp = controller.send(position=position - 0.001, current=np.arange(6.0))
            sample = one.exchange(command(position))
            answer = controller.answer()
            assert f"<IPOC>{stamp}</IPOC>" in answer
            np.testing.assert_allclose(correction(answer), position - START, atol=1e-6)
            np.testing.assert_allclose(sample.position, np.radians(position - 0.001), atol=1e-9)
            np.testing.assert_array_equal(sample.current, np.arange(6.0))
            assert sample.controller_time == first.controller_time + 4_000_000 * number
            assert (sample.skipped, sample.events, sample.fault) == (0, (), "")
            assert not sample.stale.any()
            assert (sample.lateness > 0.0) == real  # the kernel stamps the arrival
            assert np.isnan([sample.velocity, sample.torque, sample.temperature]).all()
        controller.send()
        one.exchange(None)  # holds where it was commanded last
        np.testing.assert_allclose(correction(controller.answer()), position - START, atol=1e-6)


def test_what_the_driver_states_of_itself(path):
    with by_hand(path) as controller, driver(path, timeout=10, probe=True) as one:
        info, _ = controller.begun(one)
    assert (info.cycle, info.clock, info.signals) == (0.004, "controller", ("position", "current"))
    assert "after 10 cycles (0.04 s)" in info.dead_man
    np.testing.assert_allclose(np.degrees(info.window_upper), 4.95)
    np.testing.assert_allclose(np.degrees(info.window_lower), -4.95)
    assert info.settings["start_reference"] == "ASPos"
    assert info.settings["start"] == "10 -90 90 5 45 -20 deg"
    assert info.settings["mode"] == "absolute corrections"
    assert ["after 10 late answers in a row" in text for text in info.warnings] == [True]


def test_external_axes_are_recorded_as_they_come(path):
    text = path.read_text()
    line = next(line for line in text.splitlines() if "DEF_MACur" in line)
    path.write_text(text.replace(line, line + "\n" + line.replace("DEF_MACur", "DEF_EIPos")))
    names = " ".join(f'E{k}="{100.0 * (k == 1)}"' for k in range(1, 7))
    with by_hand(path) as controller, driver(path) as one:
        info, first = controller.begun(one, more=f"<EIPos {names}/>")
        assert list(info.state) == [f"EIPos.E{k}" for k in range(1, 7)]
        np.testing.assert_array_equal(first.state, [100.0, 0, 0, 0, 0, 0])
        np.testing.assert_allclose(first.position, np.radians(START), atol=1e-9)


def test_axes_that_turn_the_other_way_or_begin_elsewhere(path):
    given = {"sign": [1, -1, 1, -1, 1, 1], "zero": [0.0, -0.5, 0, 0, 0, 0.25], "window_upper": 2.0}
    with by_hand(path) as controller, driver(path, **given) as one:
        info, sample = controller.begun(one)
        expected = np.array(given["sign"]) * np.radians(START) + given["zero"]
        np.testing.assert_allclose(sample.position, expected, atol=1e-12)
        controller.send()
        one.exchange(Command(sample.position + np.radians(1.0), np.zeros(6)))
        np.testing.assert_allclose(correction(controller.answer()), given["sign"], atol=1e-6)
    np.testing.assert_allclose(np.degrees(info.window_upper), [1.95, 4.95, 1.95, 4.95, 1.95, 1.95])
    np.testing.assert_allclose(np.degrees(info.window_lower), [-4.95, -1.95, -4.95, -1.95, -4.95, -4.95])


def test_currents_in_percent_and_torques(tmp_path):
    path = config_file(tmp_path, torque=True)
    torque = '<GearTorque A1="1" A2="2" A3="3" A4="4" A5="5" A6="6"/>'
    given = {"sign": [-1, 1, 1, 1, 1, 1], "current_unit": ["percent"] + ["A"] * 5, "i_max": 40.0}
    with by_hand(path) as controller, driver(path, **given) as one:
        info, sample = controller.begun(one, current=[50.0] * 6, more=torque)
    np.testing.assert_array_equal(sample.current, [20.0, 50.0, 50.0, 50.0, 50.0, 50.0])
    np.testing.assert_array_equal(sample.torque, [-1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert info.signals == ("position", "current", "torque")
    assert info.settings["current_unit"] == "percent A A A A A"


@pytest.mark.parametrize("beyond", [5.001, -5.001, np.nan, np.inf])
def test_a_command_beyond_the_window_is_not_sent(path, beyond):
    with by_hand(path) as controller, driver(path, overall=20.0) as one:
        controller.begun(one)
        controller.send()
        one.exchange(command(START + np.full(6, 4.9)))
        np.testing.assert_allclose(correction(controller.answer()), 4.9)
        for position in (START + np.array([0, 0, beyond, 0, 0, 0]), START):  # and nothing from then on
            controller.send()
            sample = one.exchange(command(position))
            np.testing.assert_allclose(correction(controller.answer()), 4.9)
            assert f"A3 is commanded {beyond:.4g} degrees from its start" in sample.fault
            assert not sample.sent
            assert "-5 to 5 (AXISCORR" in sample.fault


def test_the_overall_limit_counts_where_it_is_narrower(path):
    with by_hand(path) as controller, driver(path, window_upper=90.0, window_lower=-90.0) as one:
        info, _ = controller.begun(one)
        np.testing.assert_allclose(np.degrees(info.window_upper), 5.95)
        controller.send()
        assert "allows -6 to 6" in one.exchange(command(START + np.full(6, 6.01))).fault


def test_only_the_newest_telegram_is_answered(path):
    with by_hand(path) as controller, driver(path) as one:
        controller.begun(one)
        stamps = [controller.send() for _ in range(4)]
        sample = one.exchange(None)
        assert sample.skipped == 3
        assert f"<IPOC>{stamps[-1]}<" in controller.answer()
        assert controller.nothing()


def test_telegrams_twice_late_and_out_of_order_are_no_samples(path):
    with by_hand(path) as controller, driver(path) as one:
        controller.begun(one)
        stamp = controller.send()
        controller.raw(telegram(stamp))
        controller.raw(telegram(stamp - 8))
        assert one.exchange(None).events == ("1 telegram came twice", "1 telegram came too late")
        controller.raw(telegram(stamp))  # alone: not answered again
        controller.answer()
        silent = one.exchange(None)
        assert silent.stale.all()
        assert controller.nothing()
        controller.raw(telegram(stamp + 12))
        controller.raw(telegram(stamp + 8))
        sample = one.exchange(None)
        assert sample.events == ("1 telegram came too late",)
        assert f"<IPOC>{stamp + 12}<" in controller.answer()
        assert controller.nothing()


def until_lost(one):
    """Exchange until the link is lost; the samples. A starved peer may take tens of seconds."""
    samples = []
    for _ in range(10_000):
        try:
            samples.append(one.exchange(None))
        except LinkLost:
            return samples
    raise AssertionError("the link was never lost")


def test_silence_is_a_stale_sample_each_cycle_and_then_a_lost_link(path):
    with by_hand(path) as controller, driver(path, timeout=150) as one:
        _, before = controller.begun(one)
        controller.send()
        one.exchange(None)
        samples = until_lost(one)
        with pytest.raises(LinkLost, match=r"no telegram from 127.0.0.1 for .* s: RSI has ended there"):
            one.exchange(None)
        gone = len(samples) + sum(sample.skipped for sample in samples)
        for sample in samples:
            assert sample.stale.all()
            assert np.isnan(sample.position).all()
            assert sample.host_time > before.host_time
            before = sample
        assert gone >= 140  # each cycle is counted, as an exchange or as skipped
        stamp = controller.stamp
        controller.raw(telegram(stamp + 4 * 150))
        sample = one.exchange(None)  # it is back, and its cycles are not counted again
        assert sample.skipped <= max(149 - gone, 0)
        assert not sample.stale.any()


def test_a_new_session_is_a_fault_and_is_not_answered(path):
    for restart in ("jump", "back", "port"):
        with by_hand(path) as controller, driver(path) as one:
            controller.begun(one)
            controller.send(position=START)
            before = one.exchange(command(START + np.full(6, 1.0)))
            controller.answer()
            if restart == "port":
                controller.socket.close()
                controller.socket = controller.another()
            controller.send(2000 if restart == "jump" else -2000 if restart == "back" else 1)
            for _ in range(3):
                sample = one.exchange(command(START + np.full(6, 1.1)))
                assert "the controller has begun a new RSI session" in sample.fault
                np.testing.assert_allclose(sample.position, np.radians(START))
                assert sample.controller_time == before.controller_time + 4_000_000
                before = sample
                controller.send()
            assert controller.nothing()


def test_strangers_are_neither_heard_nor_answered(path):
    with by_hand(path) as controller, driver(path) as one:
        controller.begun(one)
        stranger = controller.another("127.0.0.2")
        try:
            for number in range(3):
                stranger.sendto(telegram(controller.stamp + 400, position=(0.0,) * 6), controller.to)
                controller.send()
                sample = one.exchange(None)
                np.testing.assert_allclose(sample.position, np.radians(START))
                reported = ("something from 127.0.0.2 was ignored: only 127.0.0.1 is accepted",)
                assert sample.events == (reported if not number else ())
            stranger.setblocking(False)
            with pytest.raises(BlockingIOError):
                stranger.recv(100)
        finally:
            stranger.close()
        assert one._talk.link.strangers == 3


def test_no_bytes_from_the_controllers_address_break_an_exchange(path):
    rng = np.random.default_rng(1)
    with by_hand(path) as controller, driver(path) as one:
        controller.begun(one)
        other = controller.another()
        try:
            for _ in range(200):
                other.sendto(rng.bytes(rng.integers(0, 1500)), controller.to)
                other.sendto(telegram(controller.stamp)[: rng.integers(0, 300)], controller.to)
                controller.send()
                sample = one.exchange(None)
                assert sample.events == ("2 telegrams could not be read",)
                np.testing.assert_allclose(sample.position, np.radians(START))
                assert sample.fault == ""
        finally:
            other.close()


def test_late_answers_that_the_controller_counts_are_reported_when_they_grow(path):
    with by_hand(path) as controller, driver(path) as one:
        info, _ = controller.begun(one, delay=2)
        assert info.settings["late_answers_at_start"] == "2"
        reported = []
        for delay in (2, 3, 3, 0, 1):
            controller.send(delay=delay)
            reported.append(one.exchange(None).events)
        assert reported[1] == ("the controller counts 3 late answers, 2 before (Delay)",)
        assert reported[4] == ("the controller counts 1 late answer, 0 before (Delay)",)
        assert reported[0] == reported[2] == reported[3] == ()


def test_a_programmed_pose_that_moves_is_reported_once(path):
    with by_hand(path) as controller, driver(path) as one:
        controller.begun(one)
        reported = []
        for moved in (0.0, 0.05, 0.3, 0.5):
            controller.send(programmed=np.add(START, moved))
            reported.append(one.exchange(None).events)
        assert [len(events) for events in reported] == [0, 0, 1, 0]
        assert "the programmed pose (ASPos) moved by 0.3 degrees" in reported[2][0]


def test_the_thread_holds_the_arm_until_the_first_exchange(path):
    with by_hand(path) as controller, driver(path) as one:
        controller.opened(one)
        while not controller.nothing():
            pass
        for _ in range(3):
            stamp = controller.send()
            text = controller.answer()
            while f"<IPOC>{stamp}<" not in text:
                text = controller.answer()
            np.testing.assert_array_equal(correction(text), 0.0)
    assert one._keeper is None


def test_nothing_is_answered_before_the_arm_was_looked_at(path):
    with by_hand(path) as controller, driver(path) as one:
        with pytest.raises(NotReady, match="A2 is 0.6 degrees from its programmed pose, limit 0.5"):
            controller.opened(one, position=np.add(START, [0, 0.6, 0, 0, 0, 0]))
        assert controller.nothing()


def test_an_arm_that_moves_is_not_taken_over(path):
    with by_hand(path) as controller, driver(path) as one:

        def send(cycles=1, **_):
            controller.stamp += 4
            moved = START + 1e-2 * np.array([controller.stamp % 1000, 0, 0, 0, 0, 0])
            controller.raw(telegram(controller.stamp, position=moved, programmed=moved))

        controller.send = send
        with pytest.raises(NotReady, match="the arm moves: A1 by 0.12 degrees in 3 cycles"):
            controller.opened(one)


def test_another_cycle_than_the_settings_is_refused(path):
    with by_hand(path, cycle=12) as controller, driver(path) as one:
        with pytest.raises(NotReady, match=r"sends every 12 ms, not every 4 ms. Set cycle to 0.012"):
            controller.opened(one)


def test_coarse_positions_give_a_warning(path):
    with by_hand(path) as controller, driver(path) as one:
        controller.send = lambda **_: (
            setattr(controller, "stamp", controller.stamp + 4),
            controller.raw(telegram(controller.stamp).replace(b".0000", b".0")),
        )
        info = controller.opened(one)
    assert any("positions come in steps of 0.1 degrees" in text for text in info.warnings)
    assert info.settings["position_decimals"] == "1"


def test_a_start_without_programmed_pose_is_where_the_arm_is(tmp_path):
    path = config_file(tmp_path)
    path.write_text(path.read_text().replace("DEF_ASPos", "DEF_RSol"))
    with by_hand(path) as controller, driver(path) as one:
        info, _ = controller.begun(one, programmed=(0.0,) * 6)
    assert info.settings["start_reference"] == "AIPos"
    assert info.settings["start"] == "10 -90 90 5 45 -20 deg"


def test_a_missing_controller_is_reported_with_what_to_do(path, caplog, clock):
    with driver(path, wait=0.05) as one:
        with pytest.raises(NotReady, match=r"nothing arrived at 127.0.0.1:\d+ .* Start the RSI program on"):
            one.open()
    with by_hand(path) as controller, driver(path, wait=1.0) as one:
        data = telegram(1).replace(b"MACur", b"MECur")
        controller.send = lambda **_: controller.raw(data)
        with pytest.raises(
            NotReady, match="lacks MACur.A1, MACur.A2, .* Does the controller use another"
        ) as error:
            controller.opened(one)
        port = controller.socket.getsockname()[1]
        assert f"127.0.0.1:{port} sent {len(data)} bytes (<Rob Type=" in str(error.value)
        assert f"{data[:80].decode()}...) to " in str(error.value)
    with by_hand(path) as controller, driver(path, wait=1.0) as one:
        controller.send = lambda **_: controller.raw(b"\xff\x00\n")
        with pytest.raises(NotReady, match=r"sent 3 bytes \(\\xff\\x00\\n\) to "):
            controller.opened(one)
    with by_hand(path) as controller, driver(path, wait=1.0) as one:
        controller.socket.close()
        controller.socket = controller.another("127.0.0.2")
        port = controller.socket.getsockname()[1]
        with pytest.raises(
            NotReady, match=rf"but 127.0.0.2:{port} sent \d+ bytes \(<Rob .* set controller to"
        ):
            controller.opened(one)
    with by_hand(path) as controller, driver(path, wait=1.0) as one:
        stamps = iter([100])
        controller.send = lambda **_: [controller.raw(telegram(stamp)) for stamp in stamps]
        with pytest.raises(NotReady, match="sent 1 telegram to .* and then none for 1 s"):
            controller.opened(one)
    with by_hand(path) as controller, driver(path) as one, caplog.at_level(logging.WARNING):
        late = controller.send
        begin = clock.monotonic()
        controller.send = lambda **given: late(**given) if clock.monotonic() > begin + 1.2 else None
        controller.opened(one)
        assert "start the RSI program on the controller" in caplog.text


def test_addresses_and_ports_that_cannot_be(tmp_path):
    with pytest.raises(BadSettings, match=r"cannot listen on 192.0.2.1:\d+.* IP_NUMBER must be the address"):
        driver(config_file(tmp_path), bind="192.0.2.1").open()
    path = config_file(tmp_path)
    with by_hand(path) as controller, driver(path) as one, driver(path) as other:
        controller.opened(one)
        with pytest.raises(NotReady, match="is taken by another program"):
            other.open()


def test_a_quick_stop_sets_the_stop_channel_and_goes_on_listening(path):
    with by_hand(path) as controller, driver(path) as one:
        controller.begun(one)
        controller.send()
        one.exchange(command(START + np.full(6, 0.5)))
        assert "<Stop>0</Stop>" in controller.answer()
        one.stop(StopLevel.BRAKE)
        controller.send()
        one.exchange(None)
        assert "<Stop>0</Stop>" in controller.answer()
        one.stop(StopLevel.QUICK)
        controller.send()
        assert not one.exchange(None).stale.any()
        text = controller.answer()
        assert "<Stop>1</Stop>" in text
        np.testing.assert_allclose(correction(text), 0.5)
        one.stop(StopLevel.OFF)
        controller.send()
        assert not one.exchange(None).stale.any()
        assert controller.nothing()


def test_a_quick_stop_without_a_channel_answers_no_more(tmp_path):
    path = config_file(tmp_path, stop=False)
    with by_hand(path) as controller, driver(path) as one:
        info, _ = controller.begun(one)
        assert any("no Stop channel" in text for text in info.warnings)
        one.stop(StopLevel.QUICK)
        controller.send()
        assert not one.exchange(None).stale.any()
        assert controller.nothing()


def test_closing_ends_the_controllers_program_and_may_be_done_again(path):
    with by_hand(path) as controller:
        one = driver(path)
        one.close()
        one.stop(StopLevel.OFF)
        controller.opened(one)
        while not controller.nothing():
            pass
        controller.send()
        one.close()
        texts = [controller.answer()]
        while not controller.nothing():
            texts.append(controller.answer())
        one.close()
        with pytest.raises(LinkLost, match="not open"):
            one.exchange(None)
        again = controller.another()
        again.close()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(controller.to)


def swing(one, start, seconds, degrees=2.0):
    """Follow a cosine; samples and what was commanded, shapes (t,) and (t, n)."""
    samples, commands = [], []
    for number in range(round(seconds / 0.004)):
        position = start + np.radians(degrees) * (1 - np.cos(5.0 * 0.004 * number))
        samples.append(one.exchange(Command(position, np.zeros(len(start)))))
        commands.append(position)
    return samples, np.array(commands)


def test_a_controller_in_real_time_with_a_bad_network(tmp_path):
    path = config_file(tmp_path)
    faults = {"drop": "150,160-162", "duplicate": "200,210", "reorder": "250", "delay": "300:0.002"}
    options = [text for name, cycles in faults.items() for text in (f"--{name}", cycles)]
    signs = ["--sign=1,-1,1,-1,1,1", "--zero=0,0,0.1,0,0,0"]
    given = {"sign": [1, -1, 1, -1, 1, 1], "zero": [0, 0, 0.1, 0, 0, 0]}
    with running(path, "--timeout", 500, "--seconds", 30, *options, *signs) as peer:
        with driver(path, **given) as one:
            one.open()
            start = one.exchange(None).position
            samples, commands = swing(one, start, 2.0)
        reported = counted(peer)
    assert reported["stopped"] == "stopped by the Stop channel"
    assert reported["clamped"] == 0
    assert reported["rejected"].keys() <= {"late"}
    assert all(sample.fault == "" for sample in samples)
    received = [sample for sample in samples if not sample.stale.any()]
    assert len(received) > 0.8 * len(samples)
    # what the arm did is what was commanded, a few cycles ago
    measured = np.array([sample.position for sample in received])
    moved = np.degrees(np.ptp(measured, axis=0))
    np.testing.assert_allclose(moved, np.degrees(np.ptp(commands, axis=0)), rtol=0.1)
    # nothing is uncounted: stamps go on by the exchange and the skipped ones
    for before, after in pairwise(samples):
        if not before.stale.any() and not after.stale.any():
            gone = after.controller_time - before.controller_time
            assert gone == 4_000_000 * (1 + after.skipped)
    gone = received[-1].controller_time - received[0].controller_time
    assert gone >= 4_000_000 * (len(received) - 1 + 4)  # four were dropped
    events = " ".join(text for sample in samples for text in sample.events)
    assert "came twice" in events
    assert "came too late" in events


def test_a_stall_of_the_network_is_survived(tmp_path):
    path = config_file(tmp_path)
    with running(path, "--timeout", 500, "--seconds", 30, "--stall", "150:0.1") as peer, driver(path) as one:
        one.open()
        samples, _ = swing(one, one.exchange(None).position, 1.0, degrees=0.5)
        stale = [number for number, sample in enumerate(samples) if sample.stale.all()]
        assert stale
        after = samples[stale[-1] + 1 :]
        assert after
        assert not any(sample.fault for sample in samples)
        one.close()
        assert counted(peer)["stopped"] == "stopped by the Stop channel"


def test_a_driver_that_falls_silent_is_stopped_by_the_controller(tmp_path):
    path = config_file(tmp_path, stop=False)
    with running(path, "--timeout", 20, "--seconds", 30) as peer, driver(path, timeout=20) as one:
        one.open()
        one.exchange(None)
        one.stop(StopLevel.QUICK)
        until_lost(one)
        reported = counted(peer)
    assert reported["stopped"] == "KSS29002 ETHERNET1 RSITimeout"
    assert reported["max_consecutive_late"] == 21


def test_a_krc2_that_moves_by_itself_is_listened_to(tmp_path):
    path = config_file(tmp_path, only_send=True)
    options = ("--generation", "KRC2", "--nested", "--swing", 3, "--i-max", 10, "--seconds", 30)
    given = {"generation": "KRC2", "cycle": 0.012, "current_unit": "percent", "i_max": 10.0}
    with driver(path, wait=0.01, **given) as one, pytest.raises(NotReady):
        one.open()
    with running(path, *options) as peer, driver(path, **given) as one:
        info = one.open()
        assert info.settings["mode"] == "log only"
        assert (info.window_lower, info.dead_man) == (None, "")
        samples = [one.exchange(None) for _ in range(100)]
        with pytest.raises(BadSettings, match="only listens"):
            one.exchange(command([0.0] * 6))
        one.stop(StopLevel.QUICK)
        one.close()
        reported = counted(peer)
    received = [sample for sample in samples if not sample.stale.any()]
    position = np.degrees([sample.position for sample in received])
    assert np.ptp(position, axis=0).min() > 2.0
    steps = np.diff([sample.controller_time for sample in received])
    assert steps.min() == 12_000_000
    assert np.abs(np.array([sample.current for sample in received])).max() < 10.0
    assert reported["answered"] == 0
    assert reported["rejected"] == {}


def test_an_answer_that_came_too_late_is_given_again_before_the_next(tmp_path):
    path = config_file(tmp_path)

    def answered(controller, one, degrees, **content):
        controller.send(**content)
        start = np.radians(START)
        sample = one.exchange(Command(start + np.radians([degrees, 0, 0, 0, 0, 0]), np.zeros(6)))
        return sample.sent, float(re.search(r'<AK A1="([-\d.]+)"', controller.answer())[1])

    with driver(path) as one, by_hand(path) as controller:
        controller.begun(one)
        assert answered(controller, one, 0.01) == (True, 0.01)
        # The controller counts one more late answer, and none of its telegrams went unanswered.
        assert answered(controller, one, 0.02, delay=1) == (False, 0.01)
        assert answered(controller, one, 0.02, delay=1) == (True, 0.02)
        # A telegram that was not answered at all is one more too, and nothing to give again.
        assert answered(controller, one, 0.03, delay=2, cycles=2) == (True, 0.03)
