from dataclasses import replace

import numpy as np
import pytest

import exidyn.trajectories.planning.by_rule as chirps
from exidyn.trajectories.clearances.region import Region, box
from exidyn.trajectories.errors import BadLimits, Infeasible
from exidyn.trajectories.families.chirp import Chirp, derivatives
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.limits.leads import with_leads
from exidyn.trajectories.planning.by_rule import STEPS, with_chirp
from exidyn.trajectories.planning.rests import Workspace
from exidyn.trajectories.trajectory import UNITS

from ...parts.small.two_joints import arm

pytestmark = pytest.mark.slow

LIMITS = arm().limits
TICK = 0.002
REST = Phases.hold(np.array([0.1, -0.3]), 8.0)


def moving():
    sine, cosine = 0.15 * np.random.default_rng(0).normal(size=(2, 2, 3))
    return Fourier(8.0, np.zeros(2), sine, cosine)


CHIRPS = {
    "rest": lambda: with_chirp(REST, [1], Workspace(LIMITS, TICK)),
    "moving": lambda: with_chirp(moving(), [0, 1], Workspace(LIMITS, TICK)),
    "even": lambda: replace(with_chirp(REST, [1, 0], Workspace(LIMITS, TICK)), logarithmic=False),
    "later": lambda: Chirp(REST, (0,), np.array([[0.5, 0.5, 3.0, 80.0]]), 2.0, 9.0, 1.5, 4.0, 2.0),
}


@pytest.fixture(params=CHIRPS)
def chirp(request):
    return CHIRPS[request.param]()


def alone(chirp, time):
    """Position to jerk of the chirp without what is under it, shape (4, t, n)."""
    return np.stack(chirp.at(time)[1:]) - np.stack(chirp.base.at(time)[1:])


def test_derivatives_meet_finite_differences(chirp):
    time = np.random.default_rng(1).uniform(0.01, chirp.duration - 0.01, 400)
    step = 1e-5
    here, before, after = (np.stack(chirp.at(time + s)[1:]) for s in (0.0, -step, step))
    slope = (after - before) / (2 * step)
    for order in (1, 2, 3):
        largest = np.max(np.abs(here[order]))
        np.testing.assert_allclose(slope[order - 1], here[order], atol=1e-6 * largest)


def test_it_begins_and_ends_with_nothing(chirp):
    end = chirp.begin + chirp.length
    outside = np.array([0.0, chirp.begin, chirp.begin + 1e-8, end - 1e-8, end, chirp.duration])
    np.testing.assert_allclose(alone(chirp, outside)[:3], 0.0, atol=1e-6)


def test_the_frequency_is_that_of_its_zeros(chirp):
    """Counted on the motion itself: half a period from each zero to the next."""
    time = np.linspace(chirp.begin + 1e-6, chirp.begin + chirp.length - 1e-6, 100_001)
    wave = alone(chirp, time)[0, :, chirp.joints[0]]
    crossings = np.flatnonzero(np.diff(np.signbit(wave)))[2:-2]
    exact = time[crossings] - wave[crossings] * (time[1] - time[0]) / (wave[crossings + 1] - wave[crossings])
    counted, middle = 0.5 / np.diff(exact), 0.5 * (exact[1:] + exact[:-1])
    share = (middle - chirp.begin) / chirp.length
    line, doubling = np.interp(share, [0, 1], [chirp.low, chirp.high]), (chirp.high / chirp.low) ** share
    expected = chirp.low * doubling if chirp.logarithmic else line
    np.testing.assert_allclose(counted, expected, rtol=0.02)


def test_extremes_are_bounds_and_near_what_is_reached(chirp):
    """Of the chirp alone, so that what is added for a base that moves does not hide how near."""
    size = np.abs(alone(chirp, np.linspace(0.0, chirp.duration, 100_001))).max(axis=1)
    for place, joint in enumerate(chirp.joints):
        found = size[:, joint]
        assert np.all(chirp.reached[place] >= found)
        np.testing.assert_allclose(chirp.reached[place], found, rtol=0.01)
    states = chirp.at(np.linspace(0.0, chirp.duration, 100_001))
    for name, found in zip(UNITS, chirp.extremes(), strict=True):
        assert np.all(found.upper >= getattr(states, name).max(axis=0))
        assert np.all(found.lower <= getattr(states, name).min(axis=0))


@pytest.mark.parametrize("order", [0, 2, 5])
def test_the_bound_of_each_derivative_holds_inside_its_cells(chirp, order):
    left, right = chirp._edges[:-1], chirp._edges[1:]
    bound = derivatives(chirp._bound(left, right))[order]
    for share in np.linspace(0.01, 0.99, 7):
        size = np.abs(derivatives(chirp._jet(left + share * (right - left), 6))[order])
        assert np.all(size <= bound)


@pytest.mark.parametrize(("share", "base"), [(0.2, REST), (1.0, moving())])
def test_it_uses_its_share_of_what_the_motion_leaves_and_no_more(share, base, monkeypatch):
    monkeypatch.setattr(chirps, "SHARE", share)
    chirp = with_chirp(base, [0, 1], Workspace(LIMITS, TICK))
    assert check(chirp, LIMITS, TICK) == []
    assert check(with_leads(chirp, LIMITS, TICK), LIMITS, TICK) == []
    used = []
    for under, limit in zip(base.extremes(), (2.5, 3.0, 12.0, 200.0), strict=True):
        used.append(share * np.minimum(limit - under.upper, limit + under.lower))
    used = chirp.reached / np.array(used).T
    assert np.all(used <= 1.0 + 1e-9)
    assert np.all(used.max(axis=1) > 0.9)


def test_it_shrinks_until_it_can_be_stopped(monkeypatch):
    """A tenth of a radian from a limit, where full speed would run over it."""
    monkeypatch.setattr(chirps, "SHARE", 1.0)
    near = Phases.hold(np.array([2.4, 0.0]), 8.0)
    chirp = with_chirp(near, [0], Workspace(LIMITS, TICK))
    assert check(chirp, LIMITS, TICK) == []
    free = with_chirp(Phases.hold(np.zeros(2), 8.0), [0], Workspace(LIMITS, TICK))
    assert chirp.reached[0, 1] < 0.9 * free.reached[0, 1]


def test_it_ends_at_20_hz_or_six_sampling_periods_and_needs_room():
    assert with_chirp(REST, [0], Workspace(LIMITS, 0.002)).high == pytest.approx(20.0)
    assert with_chirp(REST, [0], Workspace(LIMITS, 0.012)).high == pytest.approx(1 / 0.072)
    with pytest.raises(BadLimits, match=r"sampling period of 0.2 s allows up to 0.8333 Hz"):
        with_chirp(REST, [0], Workspace(LIMITS, 0.2))
    reached = moving().extremes()
    tight = replace(LIMITS, velocity=np.array([3.0, float(reached.velocity.upper[1])]))
    with pytest.raises(Infeasible, match="joint 2: the velocity of the base motion"):
        with_chirp(moving(), [0, 1], Workspace(tight, TICK))


def test_a_coarse_encoder_lowers_the_highest_frequency(monkeypatch):
    whole = with_chirp(REST, [0], Workspace(LIMITS, TICK))
    coarse = 1.01 / STEPS * float(whole.amplitude(np.array([10.0]))[0, 0])
    monkeypatch.setattr(chirps, "RESOLUTION", coarse)
    assert 4.0 < with_chirp(REST, [0], Workspace(LIMITS, TICK)).high < 10.0
    monkeypatch.setattr(chirps, "RESOLUTION", 100.0 * coarse)
    with pytest.raises(Infeasible, match=r"joint 1: at \d.* from .* Hz on .* Try"):
        with_chirp(REST, [0], Workspace(LIMITS, TICK))


def floor(depth):
    """A floor so far under the flange at the pose of `REST` [m]."""
    wide = np.full(3, 9.0)
    room = Region.of(arm(), "flange", box(-wide, wide)).points(REST.position)[0, 2]
    return Region.of(arm(), "flange", box(np.array([-9.0, -9.0, room - depth]), wide))


def test_nothing_is_in_contact():
    free = with_chirp(REST, [0, 1], Workspace(LIMITS, TICK))
    near = floor(0.02)
    kept = with_chirp(REST, [0, 1], Workspace(LIMITS, TICK, [near]))
    assert not near.worst(free).allowed
    assert near.worst(kept).allowed
    assert not near.worst(kept.scaled(1 / 0.8)).allowed
    with pytest.raises(
        Infeasible, match=r"the motion under the chirp: flange z >= .* m misses its safety margin"
    ):
        with_chirp(REST, [0, 1], Workspace(LIMITS, TICK, [floor(-0.02)]))


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"joints": (2,)}, "expected different ones of 0 to 1"),
        ({"largest": np.array([[1.0, 1.0, 1.0, np.nan]])}, "above 0"),
        ({"high": 2.0}, "from 2 to 2 Hz"),
        ({"length": 7.0}, "base motion of 8 s"),
        ({"fade": 2.1}, "fades of 2.1 s"),
    ],
)
def test_fields_that_make_no_chirp_are_refused(wrong, words):
    with pytest.raises(BadLimits, match=words):
        replace(CHIRPS["later"](), **wrong)
