"""Measurements that cannot be of their cycle, and those that only look like it."""

import numpy as np
import pytest

from exidyn.drivers.kuka_rsi.plausibility import ALIVE, FASTEST, STEPS, WITNESSES, Plausibility

AXES = ("A1", "A2", "A3", "A4", "A5", "A6")
CYCLE, STEP = 0.004, 1e-4


class Arm:
    """Positions (columns 0 to 5) and currents (6 to 11) of an arm of which axis 2 moves by some steps."""

    def __init__(self, noisy=6, steps=2 * STEPS, current=5.0, **changes):
        given = {"effort": (slice(6, 12), None), "step": STEP, "cycle": CYCLE} | changes
        self.judge = Plausibility(AXES, slice(0, 6), **given)
        self.random, self.noisy, self.steps, self.mean = np.random.default_rng(0), noisy, steps, current
        self.position, self.numbers = np.zeros(6), np.zeros(12)

    def go(self, cycles, spike=0.0):
        """Stale axes of each cycle; a spike is in the position of axis 3 [deg]."""
        stale = []
        for _ in range(cycles):
            self.position[1] += self.steps * STEP
            current = np.full(6, self.mean)
            current[: self.noisy] += 0.1 * self.random.standard_normal(self.noisy)
            self.numbers = np.concatenate((self.position + spike * np.eye(6)[2], current))
            stale.append(self.judge.implausible(self.numbers, 1))
        return np.array(stale)

    def repeat(self, cycles=1):
        return np.array([self.judge.implausible(self.numbers, 1) for _ in range(cycles)])


def test_measurements_that_repeat_while_the_arm_moves_are_stale_until_they_change():
    arm = Arm()
    assert not arm.go(ALIVE + 1).any()
    assert arm.repeat(3).all()
    assert arm.judge.events() == (
        "the controller sent an old measurement under a new time stamp (1 so far): positions and motor "
        "currents repeat to the last digit while the arm moves",
    )
    assert not arm.go(5).any()
    assert arm.repeat(6).all()
    assert arm.judge.events() == ()
    assert arm.repeat().all()
    assert "(10 so far)" in arm.judge.events()[0]


def test_a_controller_that_measures_only_in_every_third_cycle_is_recognized():
    arm = Arm()
    for _ in range(ALIVE + 1):
        arm.go(1)
        arm.repeat(2)
    assert not arm.go(1).any()
    assert arm.repeat(2).all()


@pytest.mark.parametrize(
    "changes",
    [
        {"steps": 0},  # at rest
        {"steps": STEPS - 1},  # slowly
        {"noisy": WITNESSES - 1},  # constant currents, as of simulators
        {"effort": (None, None)},
        {"effort": (None, slice(6, 12))},  # torques that may be a model's
    ],
)
def test_a_repetition_that_may_be_true_is_none(changes):
    arm = Arm(**changes)
    arm.go(ALIVE + 1)
    assert not arm.repeat(5).any()
    assert arm.judge.events() == ()


def test_an_arm_whose_drives_went_off_stands():
    arm = Arm()
    arm.go(ALIVE + 1)
    arm.noisy, arm.mean = 0, 0.0
    arm.go(1)
    assert not arm.repeat(5).any()


def test_one_axis_that_stands_while_currents_change_is_no_proof():
    arm = Arm()
    arm.go(ALIVE + 1)
    arm.steps = 0
    assert not arm.go(50).any()


@pytest.mark.parametrize("spike", [-40.0, 1e9])
def test_a_position_that_no_axis_reaches_is_stale_for_that_axis(spike):
    arm = Arm()
    arm.go(3)
    stale = arm.go(2, spike)
    assert stale[:, 2].all()
    assert not np.delete(stale, 2, axis=1).any()
    text = (
        f"A3 is {abs(spike):.3g} degrees from where it was 4 ms before, which no axis moves: its values are"
    )
    assert arm.judge.events() == (f"{text} not used until it is back",)
    assert not arm.go(3).any()
    arm.go(1, spike)
    assert len(arm.judge.events()) == 1


@pytest.mark.parametrize("cycles", [1, 10])
def test_a_fast_axis_is_plausible_also_after_lost_telegrams(cycles):
    judge = Plausibility(AXES, slice(0, 6), (None, None), STEP, CYCLE)
    farthest = FASTEST * CYCLE * cycles
    assert not judge.implausible(np.zeros(6), 1).any()
    assert not judge.implausible(np.full(6, 0.99 * farthest), cycles).any()
    assert judge.implausible(np.full(6, 2.02 * farthest), cycles).all()


def test_an_axis_at_rest_is_looked_at_as_closely_after_a_long_time():
    arm = Arm(steps=0, noisy=0)
    arm.go(5000)
    assert arm.go(1, 13.0)[0, 2]
