import numpy as np
import pytest

from exidyn.trajectories.errors import BadLimits, OutsideTrajectory
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.trajectory import UNITS, State


def random_phases(seed, pieces=6, joints=3):
    """Pieces of every length from nothing to a second; some without jerk, some at rest."""
    random = np.random.default_rng(seed)
    start = State(*random.normal(size=(3, joints)))
    jerks = 20 * random.normal(size=(pieces, joints)) * random.integers(0, 2, (pieces, joints))
    return Phases.of_jerks(start, random.uniform(0, 1, pieces) * random.integers(0, 2, pieces), jerks)


def still(pieces=2, joints=2, **changed):
    arrays = dict.fromkeys(("position", "velocity", "acceleration", "jerk"), np.zeros((pieces, joints)))
    return Phases(**({"start": np.arange(float(pieces)), "end": float(pieces)} | arrays | changed))


def test_it_is_the_jerk_integrated():
    start = State(np.array([0.1, 0.2]), np.array([0.3, -0.4]), np.array([-0.5, 0.6]))
    motion = Phases.of_jerks(
        start, np.array([0.2, 0.0, 0.3]), np.array([[1.0, 0.0], [9.0, 9.0], [-2.0, 3.0]])
    )
    time = np.linspace(0.0, 0.5, 200_001)
    states = motion.at(time)
    np.testing.assert_array_equal(states.jerk[[0, 90_000, -1]], [[1, 0], [-2, 3], [-2, 3]])
    for lower, higher in (("position", "velocity"), ("velocity", "acceleration"), ("acceleration", "jerk")):
        change, rate = np.diff(getattr(states, lower), axis=0), getattr(states, higher)[:-1]
        np.testing.assert_allclose(
            change, rate * np.diff(time)[:, None], atol=2e-11 if lower != "acceleration" else 2e-5
        )
    np.testing.assert_array_equal(motion.state_at(0.0), start)
    np.testing.assert_allclose(motion.end_state.acceleration, [-0.5 + 0.2 - 0.6, 0.6 + 0.9])


@pytest.mark.parametrize("seed", range(6))
def test_extremes_are_reached_and_never_passed(seed):
    motion = random_phases(seed)
    fine = motion.at(np.unique(np.concatenate([np.linspace(0, motion.end, 20_001), motion.start])))
    for name, found in zip(UNITS, motion.extremes(), strict=True):
        sampled = getattr(fine, name)
        assert np.all(found.lower <= sampled.min(axis=0) + 1e-12)
        assert np.all(found.upper >= sampled.max(axis=0) - 1e-12)
        if name == "jerk":  # of a piece without length no sample can show
            continue
        for joint in range(motion.dof):
            at_lower = getattr(motion.at(found.lower_time[joint]), name)[0, joint]
            at_upper = getattr(motion.at(found.upper_time[joint]), name)[0, joint]
            np.testing.assert_allclose(
                [at_lower, at_upper], [found.lower[joint], found.upper[joint]], atol=1e-9
            )


def test_a_turn_between_two_samples_is_found():
    """Thrown upward: highest at v^2 / 2a, which no piece begins or ends at."""
    thrown = State(np.zeros(1), np.array([3.0]), np.array([-2.0]))
    found = Phases.of_jerks(thrown, np.array([4.0]), np.zeros((1, 1))).extremes().position
    np.testing.assert_allclose([found.upper[0], found.upper_time[0], found.lower[0]], [2.25, 1.5, -4.0])


def test_a_number_that_is_none_is_not_hidden():
    jerk = np.zeros((2, 2))
    jerk[0, 1] = np.nan
    found = still(jerk=jerk).extremes()
    assert np.isnan(found.jerk.upper[1])
    assert np.isnan(found.position.upper[1])
    assert found.position.upper[0] == 0.0


@pytest.mark.parametrize(
    "changed",
    [
        {"jerk": np.zeros((2, 3))},
        {"start": np.zeros(0)},
        {"start": np.array([0.0, 3.0])},
        {"end": np.inf},
        {"start": np.array([0.0, np.nan])},
    ],
)
def test_pieces_that_do_not_follow_are_refused(changed):
    with pytest.raises(BadLimits, match="Phases"):
        still(**changed)
    for time in (-0.1, 2.1, np.nan):
        with pytest.raises(OutsideTrajectory):
            Phases.hold(np.zeros(2), 2.0).at(np.array([time]))
