"""Numbers that are no radians, and efforts that stay at one value while their joint moves."""

import numpy as np
import pytest

from exidyn.identification.recordings.effort_checks import unread
from exidyn.identification.recordings.misread_columns import angle_advice, in_percent, in_ticks

DEGREES = np.linspace(-40.0, 90.0, 500)
TICKS = np.round(2048 + DEGREES / 360 * 4096)
OPENING = np.linspace(10.0, 90.0, 500)
RADIANS = np.radians(DEGREES)


@pytest.mark.parametrize(
    ("joint", "values", "other", "said"),
    [
        ("elbow", TICKS, TICKS, "Whole numbers, 1593 to 3072, look like steps of an encoder"),
        ("elbow", np.radians(TICKS), np.radians(TICKS), "1593 to 3072, look like steps of an encoder"),
        ("elbow", 16 * (TICKS - 2048), TICKS, "-7280 to 16384, look like steps of an encoder"),
        ("elbow", 11.4 * TICKS, TICKS, "It is impossible in degrees too. If it is in counts of an encoder"),
        ("gripper", OPENING, RADIANS, "looks like per cent of what a gripper opens"),
    ],
)
def test_what_the_numbers_look_like(joint, values, other, said):
    assert said in angle_advice(joint, values, other[None])


@pytest.mark.parametrize(
    ("joint", "values", "other"),
    [("elbow", DEGREES, DEGREES), ("gripper", OPENING, DEGREES), ("elbow", OPENING, RADIANS)],
)
def test_what_may_be_degrees_is_left_to_options_that_are_tried(joint, values, other):
    assert angle_advice(joint, values, other[None]) == ""


@pytest.mark.parametrize(("joint", "there"), [("left_finger1", True), ("handle", False), ("wrist", False)])
def test_only_what_opens_is_in_per_cent(joint, there):
    assert in_percent(joint, OPENING) == there


def test_whole_degrees_are_no_steps():
    assert not in_ticks(np.round(OPENING))


@pytest.mark.parametrize("step", [1.0, 2 * np.pi / 4096, 360.0 / 4096])
def test_positions_with_a_sign_bit_are_named_as_such(step):
    """As servos of Feetech send them: -45 is 32768 + 45."""
    counts = np.rint(900.0 * np.sin(np.linspace(0.0, 12.0, 500)))
    column = step * np.where(counts < 0, 2.0**15 - counts, counts)
    advice = angle_advice("elbow", column, np.empty((0, 500)))
    assert "bit 15, as part of the number: -45 is 32813" in advice
    assert "degrees" not in advice


TIME = np.arange(1000) / 100.0
POSITION = np.stack([np.sin(TIME), np.cos(2.0 * TIME)], axis=1)


def effort(kept: float) -> np.ndarray:
    """Noise on both joints; on the first, all but a share of the samples are zero."""
    rng = np.random.default_rng(0)
    found = rng.normal(size=POSITION.shape)
    found[rng.random(len(TIME)) > kept, 0] = 0.0
    return found


def test_efforts_are_unread_where_most_samples_of_a_moving_joint_are_zero():
    share = unread(TIME, POSITION, effort(0.1))
    assert share[0] == pytest.approx(0.9, abs=0.03)
    assert share[1] == 0.0
    assert not unread(TIME, POSITION, effort(0.6)).any()
    still = POSITION.copy()
    still[:600] = still[600]
    held = effort(1.0)
    held[:600] = 3.0
    assert not unread(TIME, still, held).any()
    assert not unread(TIME[:40], POSITION[:40], np.zeros((40, 2))).any()


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e308])
def test_positions_that_are_none_are_left_out(wrong):
    damaged = POSITION.copy()
    damaged[100:103] = wrong, -wrong
    assert unread(TIME, damaged, effort(0.1)) == pytest.approx(unread(TIME, POSITION, effort(0.1)), abs=0.01)
    assert not unread(TIME, np.full_like(POSITION, wrong), effort(0.1)).any()
