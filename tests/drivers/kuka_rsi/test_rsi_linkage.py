"""The patterns of the probe, and what is concluded from the motions in them."""

import itertools

import numpy as np
import pytest

from exidyn.drivers.kuka_rsi.linkage import Linkage, pattern_table

AXES = ("A1", "A2", "A3", "A4", "A5", "A6")
SIZE = 0.01
TABLE = SIZE * pattern_table(6)


def linkage(motions, corrections=TABLE):
    return Linkage(AXES, corrections, motions, SIZE)


@pytest.mark.parametrize(("axes", "patterns"), [(1, 2), (2, 3), (3, 3), (4, 4), (6, 4), (7, 5), (12, 6)])
def test_no_two_axes_are_corrected_in_the_same_patterns(axes, patterns):
    table = pattern_table(axes)
    assert table.shape == (patterns, axes)
    assert (table.sum(axis=0) == 2).all()
    assert len({tuple(column) for column in table.T}) == axes


def test_every_permutation_but_none_is_refused_and_each_moved_axis_is_named():
    for outputs in itertools.permutations(range(6)):
        result = linkage(TABLE[:, outputs])
        assert result.agrees == (outputs == tuple(range(6)))
        assert not result.stuck or result.agrees
        refusal = result.refusal()
        for place, output in enumerate(outputs):
            named = f"{AXES[place]} moved when {AXES[output]} was corrected" in refusal
            assert named == (place != output)


def test_an_axis_that_also_follows_another_is_named_with_it():
    motions = TABLE.copy()
    motions[:, 2] += TABLE[:, 4]
    assert "A3 moved when A5 was corrected. Link" in linkage(motions).refusal()
    motions[:, 2] = TABLE[:, 1] + TABLE[:, 4]  # without its own
    assert not linkage(motions).agrees
    assert not linkage(motions).stuck


@pytest.mark.parametrize("share", [0.41, 1.0, 1.79])
def test_a_motion_may_be_sixty_percent_less_or_eighty_more(share):
    assert linkage(share * TABLE).agrees
    assert linkage(share * TABLE).followed == pytest.approx(share * SIZE)


@pytest.mark.parametrize(("share", "stuck"), [(0.0, True), (0.39, True), (1.81, False), (-1.0, False)])
def test_any_other_motion_is_refused_and_only_a_small_one_may_be_friction(share, stuck):
    motions = TABLE.copy()
    motions[:, 3] *= share
    result = linkage(motions)
    assert not result.agrees
    assert result.stuck == stuck
    assert f"did not move the arm by this amount: A4 ({share * SIZE:.2g} instead of 0.01)" in result.refusal()


def test_an_axis_that_is_not_corrected_must_not_move():
    corrections = TABLE.copy()
    corrections[:, 0] = 0.0
    assert linkage(corrections, corrections).agrees
    moved = corrections.copy()
    moved[1, 0] = 0.005
    assert not linkage(moved, corrections).agrees
    assert "A1 (0.005 instead of 0)" in linkage(moved, corrections).refusal()
    np.testing.assert_allclose(linkage(corrections, corrections).followed, SIZE)
