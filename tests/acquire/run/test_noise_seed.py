"""Runs of the mock differ in their noise, and can be repeated."""

from exidyn.acquire.run.arms import noise_seed


def test_two_runs_of_one_seed_are_two_draws():
    assert noise_seed(0, "run") != noise_seed(0, "loaded")
    assert noise_seed(0, "run") != noise_seed(1, "run")
    assert noise_seed(3, "run") == noise_seed(3, "run")
