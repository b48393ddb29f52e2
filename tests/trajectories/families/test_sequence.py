from dataclasses import replace

import numpy as np
import pytest

from exidyn.trajectories.errors import BadLimits, Infeasible, NotContinuous
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.families.sequence import Sequence, Slowed
from exidyn.trajectories.limits.brake import stoppable
from exidyn.trajectories.limits.leads import lead_in, with_leads
from exidyn.trajectories.limits.moves import move
from exidyn.trajectories.trajectory import UNITS, State

from ...parts.small.two_joints import arm

LIMITS = arm().limits
TICK = 0.002


def series(seed=0, size=0.15, centre=0.0, period=5.0):
    sine, cosine = size * np.random.default_rng(seed).normal(size=(2, 2, 4))
    return Fourier(period, np.full(2, centre), sine, cosine)


def there_and_back():
    start, middle = State.at_rest(np.array([0.0, 0.3])), series().state_at(0.0)
    there = move(start, middle, LIMITS, TICK)
    return there, move(middle, start, LIMITS, TICK)


def test_parts_follow_one_another():
    there, back = there_and_back()
    both = Sequence((there, back, Phases.hold(np.array([0.0, 0.3]), 0.5)))
    assert both.duration == pytest.approx(there.duration + back.duration + 0.5)
    time = np.array([0.0, 0.03, there.duration, there.duration + 0.03, both.duration - 0.1])
    states = both.at(time)
    for row, (part, local) in enumerate([(there, 0.0), (there, 0.03), (back, 0.0), (back, 0.03)]):
        expected = part.at(np.array([local])).state(0)
        np.testing.assert_allclose(states.state(row), expected, atol=1e-12)
    np.testing.assert_array_equal(states.state(4), State.at_rest(np.array([0.0, 0.3])))
    np.testing.assert_array_equal(states.time, time)


def test_extremes_are_those_of_all_parts_at_their_times():
    there, back = there_and_back()
    both = Sequence((there, back))
    for name, found in zip(UNITS, both.extremes(), strict=True):
        parts = [getattr(part.extremes(), name) for part in both.parts]
        np.testing.assert_array_equal(found.lower, np.min([part.lower for part in parts], axis=0))
        np.testing.assert_array_equal(found.upper, np.max([part.upper for part in parts], axis=0))
        if name == "jerk":
            continue
        for joint in range(2):
            for value, time in ((found.upper, found.upper_time), (found.lower, found.lower_time)):
                reached = getattr(both.at(time[[joint]]), name)[0, joint]
                assert reached == pytest.approx(value[joint], abs=1e-9)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_a_jump_names_joint_quantity_and_parts(order):
    rest = Phases.hold(np.zeros(2), 1.0)
    state = State(*np.zeros((3, 2)))
    state[order][1] = 1e-5
    moving = Phases.of_jerks(state, np.array([1.0]), np.zeros((1, 2)))
    with pytest.raises(
        NotContinuous, match=f"joint 2: {State._fields[order]} jumps from 0 to 1e-05 .*parts 2 and 3"
    ):
        Sequence((rest, rest, moving))
    for parts in ((), (rest, Phases.hold(np.zeros(3), 1.0))):
        with pytest.raises(NotContinuous, match="joints"):
            Sequence(parts)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("start", [None, np.array([0.2, -0.3])])
def test_leads_begin_and_end_at_rest_and_keep_every_limit(seed, start):
    core = series(seed)
    run = with_leads(core, LIMITS, TICK, start, rest=0.5)
    rest, into, middle, out, again = run.parts
    assert middle is core
    for part in run.parts:
        assert part.duration / TICK == pytest.approx(round(part.duration / TICK), abs=1e-6)
    np.testing.assert_array_equal(rest.state_at(0.0), again.end_state)
    assert not np.any([rest.state_at(0.0).velocity, rest.state_at(0.0).acceleration])
    if start is not None:
        np.testing.assert_array_equal(rest.state_at(0.0).position, start)
    for lead in (into, out):
        assert np.all(stoppable(lead.every(TICK), LIMITS))
        reached = lead.extremes()
        assert np.all(reached.position.upper <= LIMITS.position_upper)
        assert np.all(reached.position.lower >= LIMITS.position_lower)
        assert np.all(np.maximum(reached.velocity.upper, -reached.velocity.lower) <= LIMITS.velocity + 1e-9)
    assert run.duration == pytest.approx(1.0 + into.duration + 5.0 + out.duration)


def test_a_lead_that_overshoots_a_limit_names_it():
    """It begins fast and just inside a limit, so that getting up to speed needs room beyond it."""
    core = series(seed=1)
    begin = core.state_at(0.0)
    fast = int(np.argmax(np.abs(begin.velocity)))
    forward = begin.velocity[fast] > 0
    side = "position_lower" if forward else "position_upper"
    bound = getattr(LIMITS, side).copy()
    bound[fast] = begin.position[fast] - (0.001 if forward else -0.001)
    with_leads(core, LIMITS, TICK, begin.position)
    with pytest.raises(
        Infeasible, match=rf"joint {fast + 1}: the lead-.* reaches .* limit .*Try another start"
    ):
        with_leads(core, replace(LIMITS, **{side: bound}), TICK, begin.position)
    with pytest.raises(Infeasible, match=rf"no pose was found.*joint {fast + 1}"):
        with_leads(core, replace(LIMITS, **{side: bound}), TICK)


def test_parts_start_and_end_on_sampling_periods():
    """By default it starts near: a start far off takes longer to come in from."""
    near, far = (with_leads(series(), LIMITS, TICK, start, 0.0031) for start in (None, np.array([2.0, -2.0])))
    assert near.parts[1].duration < 0.5 * far.parts[1].duration
    assert near.parts[0].duration == pytest.approx(0.004, abs=1e-12)  # a rest at least as long as asked
    with pytest.raises(
        BadLimits, match=r"5\.001 s, 2500\.5 sampling periods of 0\.002 s.*Try a duration of 5 s"
    ):
        with_leads(series(period=5.001), LIMITS, TICK)
    with pytest.raises(BadLimits, match="sampling period is"):
        with_leads(series(), LIMITS, np.nan)


def test_lead_in_from_a_measured_state_joins_the_trajectory():
    core = series()
    measured = State(np.array([-1.0, 0.7]), np.array([0.3, -0.2]), np.array([1.0, 2.0]))
    way = lead_in(measured, core, LIMITS, TICK)
    np.testing.assert_array_equal(way.state_at(0.0), measured)
    run = Sequence((way, core))
    np.testing.assert_allclose(way.end_state, core.state_at(0.0), atol=1e-8)
    assert run.duration == pytest.approx(way.duration + 5.0)


def test_a_joint_measured_outside_is_let_in_but_no_further_out():
    core = series()
    outside = State.at_rest(np.array([0.0, 2.6]))  # the limit is 2.5
    assert lead_in(outside, core, LIMITS, TICK).extremes().position.upper[1] == pytest.approx(2.6, abs=1e-9)
    leaving = State(outside.position, np.array([0.0, 0.5]), np.zeros(2))
    with pytest.raises(
        Infeasible, match=r"joint 2: the lead-in or a stop during it reaches 2\.6.* limit 2\.5"
    ):
        lead_in(leaving, core, LIMITS, TICK)


def test_slowed_is_the_same_path_and_every_rate_smaller_by_its_power():
    full, half = series(), Slowed(series(), 0.5)
    time = np.linspace(0.0, half.duration, 501)
    assert half.duration == 2 * full.duration
    for order, (fast, slow) in enumerate(zip(full.at(0.5 * time)[1:], half.at(time)[1:], strict=True)):
        np.testing.assert_allclose(slow, 0.5**order * fast)
        reached, expected = half.extremes()[order], full.extremes()[order]
        np.testing.assert_allclose(reached[:2], 0.5**order * np.array(expected[:2]))
        np.testing.assert_allclose(reached.upper_time, 2 * expected.upper_time)
    for speed in (0.0, -0.1, 1.1, np.nan):
        with pytest.raises(BadLimits, match="at most 1"):
            Slowed(full, speed)
