"""What is left: lines in spectra that two runs have."""

from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identify.diagnosis.results.remainder import line


def left(amplitude, rng, lined=(0, 1)):
    parts = [rng.normal(size=800) for _ in range(3)]
    for run in lined:
        parts[run] = parts[run] + amplitude * np.sin(2 * np.pi * 0.117 * np.arange(800) + run)
    whole = np.concatenate(parts)[:, None]
    runs = tuple(slice(800 * k, 800 * (k + 1)) for k in range(3))
    return SimpleNamespace(
        rate=100.0, rows=SimpleNamespace(runs=runs, weight=np.ones((2400, 1))), residual=whole
    )


def test_line_is_found_where_two_runs_have_it():
    assert line(left(0.6, np.random.default_rng(8)), 0) == pytest.approx(11.7, abs=0.2)


@pytest.mark.parametrize("seed", range(8))
def test_no_line_in_noise_or_in_one_run_alone(seed):
    rng = np.random.default_rng(seed)
    assert line(left(0.0, rng), 0) == 0.0
    assert line(left(0.6, rng, lined=(1,)), 0) == 0.0
