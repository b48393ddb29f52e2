"""What the probe makes of controllers that take corrections one way or the other, cycle by cycle."""

import numpy as np
import pytest

from exidyn.drivers.kuka_rsi.probe import BOUND, SIZES, Probe
from exidyn.drivers.kuka_rsi.session import Datagram, Fresh
from exidyn.drivers.kuka_rsi.telegram import TelegramReader

from ...parts.controllers.rsi_controller import START, telegram

AXES = ("A1", "A2", "A3", "A4", "A5", "A6")
READER = TelegramReader([f"AIPos.{axis}" for axis in AXES])
ROOM = 5.0 * np.ones(6)


def fresh(position, decimals):
    data = telegram(1, position=position)
    for value in set(position):
        data = data.replace(f'"{value:.4f}"'.encode(), f'"{value:.{decimals}f}"'.encode())
    return Fresh(READER.read(data), Datagram(data, 1, 0), 1, 0.0)


class Arm:
    """Moves as it is corrected; `total` is the commanded position and `furthest` the furthest it was.

    Axis k gets the correction at place `outputs[k]`, times `linked`.
    """

    def __init__(
        self,
        relative=False,
        begins=0,
        lag=0,
        slow=0.0,
        linked=1.0,
        noise=0.0,
        decimals=4,
        drift=0.0,
        outputs=range(6),
    ):
        self.outputs = list(outputs)
        self.relative, self.begins, self.lag, self.slow = relative, begins, lag, slow
        self.linked, self.noise, self.decimals, self.drift = (
            np.broadcast_to(linked, 6),
            noise,
            decimals,
            drift,
        )
        self.random = np.random.default_rng(1)
        self.total, self.place = np.zeros(6), np.zeros(6)
        self.totals, self.furthest, self.number = [], 0.0, 0

    def cycle(self, correction):
        """The telegram that the correction answers, and what comes of it."""
        noise = self.noise * self.random.standard_normal(6)
        sample = fresh(START + self.place + noise + self.drift * self.number, self.decimals)
        self.number += 1
        if self.number > self.begins:
            self.total = self.linked * correction[self.outputs] + (self.total if self.relative else 0.0)
        self.totals.append(self.total)
        target = self.totals[max(len(self.totals) - 1 - self.lag, 0)]
        self.place = target + self.slow * (self.place - target)
        self.furthest = max(self.furthest, np.abs(self.place).max())
        return sample


def probed(arm, cycle=0.004, timeout=100, lower=-ROOM, upper=ROOM):
    """The probe when it is done, and how many cycles it took."""
    probe = Probe(AXES, slice(0, 6), cycle, timeout, lower, upper)
    count = 0
    while not probe.done:
        probe.see(arm.cycle(probe.correction))
        count += 1
    for _ in range(arm.lag + 1):  # what is under way still
        arm.cycle(probe.correction)
    return probe, count


RESTS = [
    {},
    {"noise": 0.0005},
    {"noise": 0.002},
    {"noise": 0.004},
    {"lag": 12},
    {"slow": 0.8},
    {"slow": 0.8, "lag": 8, "noise": 0.001},
    {"decimals": 2},
    {"decimals": 3, "noise": 0.002},
    {"begins": 40},
    {"drift": 1e-6},
]


@pytest.mark.parametrize("rest", RESTS)
@pytest.mark.parametrize("timeout", [10, 100, 500])
@pytest.mark.parametrize("cycle", [0.004, 0.012])
def test_distances_are_taken_for_such_and_sums_refused(rest, timeout, cycle):
    taken, adding = Arm(**rest), Arm(relative=True, **rest)
    assert probed(taken, cycle, timeout)[0].fault == ""
    probe, _ = probed(adding, cycle, timeout)
    assert "corrections add up" in probe.fault
    assert "RSI_ON(#ABSOLUTE)" in probe.fault
    for arm in (taken, adding):
        assert arm.furthest < SIZES[-1] + 1e-6 < BOUND
        assert np.abs(arm.totals[-1]).max() < 1e-9  # where it stood
    assert not probe.correction.any()


def test_what_is_done_and_what_was_seen_is_reported():
    probe, count = probed(Arm())
    assert probe.events() == (
        "probing the effect of corrections by motions of 0.01 degrees, for 1.7 s",
        "corrections are distances from the start (RSI_ON(#ABSOLUTE)), and each reaches its axis: axes moved "
        "by 0.0100 to 0.0100 degrees when corrected by 0.01",
    )
    assert probe.events() == ()
    assert count == 125 + 35 + 2 * (25 + 35) + 5 * (25 + 35)  # 2.3 s


@pytest.mark.parametrize("timeout", [10, 100, 500, 10_000])
def test_no_axis_goes_further_if_this_computer_dies_in_the_middle(timeout):
    """A controller that adds holds the last correction until its timeout."""
    held, arm = [], Arm(relative=True)
    probe = Probe(AXES, slice(0, 6), 0.004, timeout, -ROOM, ROOM)
    while not probe.done:
        correction = probe.correction
        probe.see(arm.cycle(correction))
        held.append(np.abs(arm.total + timeout * correction).max())
    assert "corrections add up" in probe.fault
    assert 0.5 * SIZES[0] < max(held) < BOUND + 1e-9


def test_a_controller_that_begins_to_add_in_the_middle_is_found_out_or_harmless():
    _, count = probed(Arm(linked=0.0))
    fall = 125 + 35 + 25 + 35
    for begins in range(3, count, 17):
        arm = Arm(relative=True, begins=begins, lag=12)
        probe, _ = probed(arm)
        assert probe.fault, begins
        in_time = begins < fall + 15  # 40 % of its 25 steps are left then
        assert "corrections add up" in probe.fault or not in_time
        assert arm.furthest < (BOUND if in_time else 0.5)


@pytest.mark.parametrize("linked", [0.0, [1, 1, 0, 1, 1, 1], [0, 0, 0, 0, 0, 1], 3.0, -1.0, 0.1])
def test_corrections_without_their_effect_are_refused(linked):
    arm = Arm(linked=linked)
    probe, _ = probed(arm)
    size = (
        0.01 if np.abs(linked).max() > 1.0 or np.min(linked) < 0.0 else 0.03
    )  # tried again if nothing moved
    assert f"corrections of {size:g} degrees did not move the arm by this amount" in probe.fault
    assert "linked to AXISCORR" in probe.fault
    wrong = np.flatnonzero(np.broadcast_to(linked, 6) != 1.0)
    for place in range(6):
        assert (f"{AXES[place]} (" in probe.fault) == (place in wrong)


def test_positions_too_coarse_to_see_anything_are_refused():
    probe, _ = probed(Arm(decimals=1))
    assert "positions come in steps of 0.1 degrees" in probe.fault
    assert "Precision" in probe.fault


def test_an_arm_that_does_not_rest_is_refused():
    assert "A" in (fault := probed(Arm(noise=0.02))[0].fault)
    assert "does not stand still: its position has a standard deviation of 0.0" in fault
    assert "while its correction was" in probed(Arm(drift=5e-5))[0].fault
    arm = Arm(drift=1e-3)
    assert "does not stand still" in probed(arm)[0].fault


EXCHANGES = [
    [1, 0, 2, 3, 4, 5],
    [0, 2, 1, 3, 4, 5],
    [5, 1, 2, 3, 4, 0],
    [1, 2, 0, 3, 4, 5],
    [1, 2, 3, 4, 5, 0],
    [0, 1, 1, 3, 4, 5],
]


@pytest.mark.parametrize("outputs", EXCHANGES)
@pytest.mark.parametrize("rest", [{}, {"lag": 12, "noise": 0.002}, {"slow": 0.8, "noise": 0.004}])
def test_axes_that_follow_the_corrections_of_others_are_refused_and_named(outputs, rest):
    arm = Arm(outputs=outputs, **rest)
    fault = probed(arm)[0].fault
    assert fault.startswith("corrections reach the wrong axes: ")
    assert "Link the ETHERNET object's outputs to the inputs of AXISCORR axis by axis" in fault
    for place, output in enumerate(outputs):
        named = f"{AXES[place]} moved when {AXES[output]} was corrected" in fault
        assert named == (place != output)
    assert arm.furthest < SIZES[-1] + 1e-6
    assert np.abs(arm.totals[-1]).max() < 1e-9


@pytest.mark.parametrize("outputs", EXCHANGES)
def test_exchanged_axes_of_a_controller_that_adds_stay_within_the_bound(outputs):
    arm = Arm(relative=True, outputs=outputs)
    assert "corrections add up" in probed(arm)[0].fault
    assert arm.furthest < SIZES[-1] + 1e-6 < BOUND


def test_exchanged_axes_are_named_where_one_turns_the_other_way_or_has_no_room():
    opposite = np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0])
    arm = Arm(outputs=[0, 2, 1, 3, 4, 5], linked=opposite)
    fault = probed(arm)[0].fault
    assert "A2 moved when A3 was corrected, A3 moved when A2 was corrected" in fault
    room = ROOM * [1, 0, 1, 1, 1, 1]
    fault = probed(Arm(outputs=[0, 2, 1, 3, 4, 5]), lower=-room, upper=room)[0].fault
    assert "wrong axes: A2 moved when A3 was corrected. Link" in fault


def test_an_axis_without_room_is_not_probed():
    lower, upper = -ROOM, ROOM.copy()
    upper[1] = 0.0  # it goes the other way
    lower[2] = upper[2] = 0.0
    arm = Arm()
    probe, _ = probed(arm, lower=lower, upper=upper)
    assert probe.fault == ""
    totals = np.array(arm.totals)
    assert totals[:, 1].min() == pytest.approx(-0.01)
    assert totals[:, 1].max() < 1e-3
    assert not totals[:, 2].any()
    assert Probe(AXES, slice(0, 6), 0.004, 100, 0 * ROOM, 0 * ROOM).done


def test_given_up_it_corrects_nothing():
    probe, arm = Probe(AXES, slice(0, 6), 0.004, 100, -ROOM, ROOM), Arm()
    while not probe.correction.any():
        probe.see(arm.cycle(probe.correction))
    probe.give_up()
    assert probe.done
    assert not probe.correction.any()
