from dataclasses import dataclass, replace

import numpy as np
import pytest

from exidyn.trajectories.errors import BadLimits
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.limits import check as check_module
from exidyn.trajectories.limits.brake import Reach
from exidyn.trajectories.limits.check import VIOLATED, Violation, check, torque_peaks
from exidyn.trajectories.trajectory import Extremes, Range, State, States, Trajectory

from ...parts.small.two_joints import arm, model, true_values

LIMITS = arm().limits
TICK = 0.002


def series(seed=0, size=0.1):
    sine, cosine = size * np.random.default_rng(seed).normal(size=(2, 2, 4))
    return Fourier(5.0, np.array([0.1, -0.2]), sine, cosine)


def nominal_torque(states):
    of = model()
    return of.torque(states.motion(), true_values(of))


def test_what_keeps_to_every_limit_has_no_violation():
    assert check(series(), LIMITS, TICK, nominal_torque) == []
    assert check(Phases.hold(np.zeros(2), 1.0), LIMITS, TICK, nominal_torque) == []


@pytest.mark.parametrize("what", ["position", "velocity", "acceleration", "jerk"])
@pytest.mark.parametrize("side", ["lower", "upper"])
def test_a_limit_within_the_extremes_is_violated_once_and_only_it(what, side):
    """By a millionth, and only between ticks; the same limit a little further out is kept."""
    core = series()
    found = getattr(core.extremes(), what)
    worst, when = getattr(found, side)[1], getattr(found, f"{side}_time")[1]
    name = f"position_{side}" if what == "position" else what
    if what in ("velocity", "acceleration") and side == "lower":
        name = f"{what}_lower"
    if what == "jerk":  # the same both ways, so that only the larger matters
        worst = np.max(np.abs([found.lower[1], found.upper[1]])) * np.sign(worst)
    sign = -1.0 if name == "jerk" and worst < 0 else 1.0

    def limited(factor):
        values = getattr(LIMITS, name).copy()
        values[1] = sign * worst * factor
        return [v for v in check(core, replace(LIMITS, **{name: values}), TICK) if v.kind != "stop"]

    assert limited(1 + 1e-8) == []
    (violation,) = limited(1 - 1e-6)
    assert (violation.kind, violation.joint) == (what, 1)
    assert abs(violation.value) == pytest.approx(abs(worst), rel=1e-9)
    assert abs(violation.limit) == pytest.approx(abs(worst), rel=2e-6)
    assert abs(violation.value) > abs(violation.limit)
    if what != "jerk":
        assert violation.time == pytest.approx(when)


def fast_near_the_limit():
    """One joint passes 0.3 rad below its limit at 2 rad/s and turns with all that jerk allows."""
    limits = replace(LIMITS, position_upper=np.array([1.0, 2.5]), acceleration_lower=np.array([-4.0, -12.0]))
    start = State(np.array([0.7, 0.0]), np.array([2.0, 0.0]), np.zeros(2))
    return Phases.of_jerks(start, np.array([0.05]), np.zeros((1, 2))), limits


def test_what_cannot_be_stopped_in_time_is_reported():
    """Position 0.8 rad at most, but a stop from 2 rad/s at 4 rad/s^2 takes 0.5 rad and more."""
    violations = check(*fast_near_the_limit(), TICK)
    (violation,) = violations
    assert (violation.kind, violation.joint, violation.limit) == ("stop", 0, 1.0)
    # Half of 2 rad/s over 2 / 4 s and the 4 / 200 s that the acceleration takes to come.
    assert violation.value == pytest.approx(0.8 + 0.5 * 2.0 * (2 / 4 + 4 / 200), abs=1e-9)
    assert violation.time == pytest.approx(0.05)


@pytest.mark.parametrize("broken", ["stopping_reach", "brake_reach"])
def test_either_computation_of_the_stop_is_enough_to_refuse(monkeypatch, broken):
    none = Reach(np.zeros((26, 2)), np.zeros((26, 2)))
    monkeypatch.setattr(check_module, broken, lambda *_: none)
    (violation,) = check(*fast_near_the_limit(), TICK)
    assert violation.kind == "stop"


def test_torque_between_ticks_is_found():
    """A limit one millionth below the peak of a fine search is violated, one above it kept."""
    core = series()
    peak = np.max(np.abs(nominal_torque(core.at(np.linspace(0, 5, 100_001)))), axis=0)
    assert check(core, replace(LIMITS, torque=peak + [1e-4, 1e-3]), TICK, nominal_torque) == []
    found = check(core, replace(LIMITS, torque=(1 - 1e-6) * peak), 0.01, nominal_torque)
    assert [(violation.kind, violation.joint) for violation in found] == [("torque", 0), ("torque", 1)]


def test_torque_without_a_limit_or_a_model_is_not_looked_at():
    endless = replace(LIMITS, torque=np.full(2, np.inf))
    assert check(series(), endless, TICK, lambda states: pytest.fail("asked for")) == []
    assert check(series(), replace(LIMITS, torque=np.full(2, 1e-3)), TICK) == []


def test_a_motion_that_is_no_number_is_reported_and_not_passed():
    jerk = np.zeros((3, 2))
    jerk[1, 1] = np.nan
    start = State(*np.zeros((3, 2)))
    (violation,) = check(Phases.of_jerks(start, np.full(3, 0.1), jerk), LIMITS, TICK)
    assert (violation.kind, violation.joint, violation.time) == ("not finite", 1, pytest.approx(0.1))
    assert violation.sentence(("shoulder", "elbow")) == "elbow: not finite at 0.100 s: nan"


def test_no_number_between_two_ticks_and_no_torque_are_reported():
    """A piece shorter than a tick, after which everything is a number again."""
    zeros, jerk = np.zeros((3, 1)), np.array([[0.0], [np.nan], [0.0]])
    phases = Phases(np.array([0.0, 0.003, 0.0031]), 1.0, zeros, zeros, zeros, jerk)
    limits = type(LIMITS)(*np.outer([-2.5, 2.5, 3.0, 12.0, 200.0, 200.0], np.ones(1)))
    assert {violation.kind for violation in check(phases, limits, TICK)} == {"not finite"}
    broken = check(
        series(), LIMITS, TICK, lambda states: np.where(states.time[:, None] > 2.0, np.nan, [0, 0])
    )
    assert {(violation.kind, violation.joint) for violation in broken} == {
        ("not finite", joint) for joint in (0, 1)
    }


def test_limits_of_another_arm_and_a_tick_that_is_none_are_refused():
    with pytest.raises(BadLimits, match="2 joints, limits of 3"):
        check(series(), type(LIMITS).none(3), TICK)
    for tick in (0.0, np.nan):
        with pytest.raises(BadLimits, match="sampling period of"):
            check(series(), LIMITS, tick)


def test_sentences_name_joint_value_limit_and_unit():
    one = Violation("velocity", 1, 1.25, -3.5, -3.0)
    assert one.sentence(("a", "b")) == "b: velocity at 1.250 s is -3.5, limit -3 rad/s"
    assert one.sentence(("a", "b"), sliding=[1]) == "b: velocity at 1.250 s is -3.5, limit -3 m/s"
    stop = Violation("stop", 0, 0.5, 2.0, 1.0).sentence(("a", "b"))
    assert stop == "a: a stop begun at 0.500 s reaches 2, limit 1 rad"
    assert Violation("torque", 0, 0.5, 2.0, 1.0).sentence(("a",), {0}).endswith("limit 1 N")
    assert set(VIOLATED) == {"position", "velocity", "acceleration", "jerk", "stop", "torque"}


@dataclass(frozen=True, eq=False)
class Clock(Trajectory):
    """A joint whose position is the time, to have torques that are functions of time."""

    duration: float = 1.0
    dof: int = 1

    def at(self, time):
        time = self.inside(time)
        columns = time[:, None]
        return States(time, columns, np.ones_like(columns), *np.zeros((2, len(time), 1)))

    def extremes(self):
        still = Range(*np.zeros((4, 1)))
        return Extremes(Range(*np.array([[0.0], [1.0], [0.0], [1.0]])), still, still, still)


@pytest.mark.parametrize("middle", [0.30499, 0.0, 0.9971])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_peak_anywhere_is_found_with_its_time(middle, sign):
    """cos is 1 at its peak; samples are 0.01 s apart, of which it would miss up to 0.3 of its 10."""

    def torque(states):
        away = states.position - middle
        return sign * 10.0 * np.cos(50 * away) * np.exp(-5 * away**2)

    peaks = torque_peaks(Clock(), torque, 0.01)
    value, time = (peaks.upper, peaks.upper_time) if sign > 0 else (peaks.lower, peaks.lower_time)
    assert value[0] == pytest.approx(10.0 * sign, abs=1e-4)
    assert time[0] == pytest.approx(middle, abs=0.01 / 16)


def test_of_many_peaks_the_one_whose_samples_look_smaller_is_found():
    """The higher peak falls between two samples, the lower one on one."""

    def torque(states):
        time = states.position
        return 0.999 * np.exp(-(((time - 0.5) / 0.01) ** 2)) + np.exp(-(((time - 0.205) / 0.01) ** 2))

    assert torque_peaks(Clock(), torque, 0.01).upper[0] == pytest.approx(1.0, abs=1e-4)
    assert torque_peaks(Clock(), torque, 0.01).upper_time[0] == pytest.approx(0.205, abs=1e-3)
