"""The threshold: rate of false alarms on known noise, scale by speed and load, tails."""

import numpy as np
import pytest
from scipy import stats

from exidyn.identification.contact.observer import Estimates
from exidyn.identification.contact.threshold import Alarms, Tail, Threshold, block_maxima
from exidyn.identification.errors import RecordingError

SLOW = np.array([0.02, 0.02])
RATE = 50.0


def free_run(seconds, seed):
    """Noise of two joints that grows with speed, load and near rest, as `Threshold` models it."""
    random = np.random.default_rng(seed)
    time = np.arange(int(seconds * RATE)) / RATE
    velocity = np.sin(0.7 * time[:, None] + np.array([0.0, 1.0])) * np.array([0.5, 1.5])
    load = 20.0 * np.cos(0.3 * time[:, None] + np.array([0.0, 2.0]))
    scale = np.sqrt(0.04 + 0.5 * np.exp(-np.abs(velocity) / SLOW) + 0.09 * velocity**2 + 1e-3 * load**2)
    noise = scale * random.normal(size=velocity.shape)
    return Estimates(time, noise, np.zeros_like(velocity), velocity, load), scale


def test_the_scale_follows_speed_and_load():
    run, scale = free_run(600.0, 0)
    threshold = Threshold.of([run], SLOW)
    ratio = threshold.scale(run) / scale
    assert np.all(np.abs(np.quantile(ratio, [0.05, 0.95], axis=0) - 1.0) < 0.15)


NORMAL, HEAVY = stats.norm(), stats.t(5)
SAMPLES = 100
"""Independent samples in a block."""


def drawn_maxima(residual, count, random):
    """Block maxima of a residual's distribution."""
    return residual.isf((1.0 - random.random(count) ** (1.0 / SAMPLES)) / 2.0)


@pytest.mark.parametrize(("residual", "least", "most"), [(NORMAL, 0.0, 1.0), (HEAVY, 0.3, 2.0)])
@pytest.mark.parametrize("blocks", [60, 600])
def test_the_rate_of_false_alarms_is_about_the_requested_one_or_less(residual, least, most, blocks):
    """One an hour, on average over 200 calibrations of a minute and of ten."""
    random, share = np.random.default_rng(0), 1.0 / 3600.0
    levels = [Tail.of(drawn_maxima(residual, blocks, random)).exceeded_by(share) for _ in range(200)]
    exceeded = 1.0 - (1.0 - 2.0 * residual.sf(levels)) ** SAMPLES
    assert least <= exceeded.mean() / share < most


def test_tails_of_known_distributions_are_recovered():
    random = np.random.default_rng(3)
    tail = Tail.of(stats.genpareto.rvs(0.2, scale=2.0, size=20000, random_state=random))
    assert tail.shape == pytest.approx(0.2, abs=0.06)
    assert tail.exceeded_by(0.1) == pytest.approx(tail.start)
    assert tail.exceeded_by(0.001) == pytest.approx(stats.genpareto.isf(0.001, 0.2, scale=2.0), rel=0.1)
    assert tail.exceeded_by(0.9) == tail.start


def test_the_threshold_of_a_run_makes_the_requested_rate():
    threshold = Threshold.of([free_run(900.0, 1)[0]], SLOW, 20.0)
    run, _ = free_run(3600.0, 2)
    assert (block_maxima(run.time, threshold.score(run)) > threshold.level).sum() < 30
    assert threshold.hours == 0.25


def test_short_runs_give_higher_thresholds_or_none():
    long, short = (Threshold.of([free_run(seconds, 4)[0]], SLOW) for seconds in (600.0, 25.0))
    assert short.level > long.level
    assert short.hours == pytest.approx(25.0 / 3600.0)
    with pytest.raises(RecordingError, match=r"last 10 s; at least 20 s are needed"):
        Threshold.of([free_run(10.0, 0)[0]], SLOW)
    run, _ = free_run(30.0, 0)
    unknown = Estimates(run.time, np.full_like(run.torque, np.nan), run.position, run.velocity, run.load)
    with pytest.raises(RecordingError, match="no usable samples"):
        Threshold.of([unknown], SLOW)
    assert len(block_maxima(unknown.time, np.full(len(unknown), np.nan))) == 0


def test_alarms_join_within_a_block_and_pieces_give_the_same():
    run, _ = free_run(60.0, 5)
    threshold = Threshold.of([free_run(600.0, 6)[0]], SLOW)
    pushed = run.torque.copy()
    for start, end in ((10.0, 10.2), (10.8, 11.0), (20.0, 21.0), (59.9, 60.0)):
        pushed[(run.time >= start) & (run.time < end), 1] += 30.0
    whole, pieces = Alarms(threshold), Alarms(threshold)
    estimates = Estimates(run.time, pushed, run.position, run.velocity, run.load)
    whole.add(estimates)
    for k in range(0, len(run), 17):
        rows = slice(k, k + 17)
        names = ("time", "torque", "position", "velocity", "load")
        pieces.add(Estimates(*(getattr(estimates, name)[rows] for name in names)))
    for alarms in (whole, pieces):
        assert [(round(a.start, 1), round(a.end, 1), a.joint) for a in alarms.all] == [
            (10.0, 11.0, 1),
            (20.0, 21.0, 1),
            (59.9, 60.0, 1),
        ]
        assert alarms.ended == alarms.all[:-1]
        assert alarms.all[0].torque[1] > 25.0
        assert alarms.all[0].score > 1.0
