"""Columns of commands that hold none."""

import numpy as np
import pytest

from exidyn.identification.recordings.servo_error import no_commands

TIME = np.arange(0.0, 10.0, 0.02)
POSITION = np.round(np.stack([np.sin(1.7 * TIME), np.cos(2.9 * TIME)], axis=1), 4)


@pytest.mark.parametrize("samples", [0, 1, 2, 10])
def test_copied_positions_are_no_commands(samples):
    copied = POSITION[np.minimum(np.arange(len(TIME)) + samples, len(TIME) - 1)]
    words = {0: "are the positions:", 1: "of the next sample"}.get(samples, f"{samples} samples later")
    assert words in no_commands(copied, POSITION)


def test_steps_are_no_commands():
    steps = np.diff(POSITION, axis=0, append=POSITION[-1:])
    assert "look like steps" in no_commands(steps, POSITION)
    assert "look like steps" in no_commands(50.0 * steps, POSITION)


@pytest.mark.parametrize("error", [1e-3, 0.1])
def test_commands_that_a_servo_follows_are_commands(error):
    ahead = np.stack([np.sin(1.7 * (TIME + 0.02)), np.cos(2.9 * (TIME + 0.02))], axis=1)
    assert not no_commands(ahead + error * np.sin(7.0 * TIME)[:, None], POSITION)
