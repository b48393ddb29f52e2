"""Jumps between the pieces of a motion are named; motions of every family have none."""

from dataclasses import replace

import pytest

from exidyn.trajectories.families import FAMILIES
from exidyn.trajectories.families.sequence import Slowed
from exidyn.trajectories.plans.plan_check import jumps, violations

from ...parts.plans.plans import SAMPLES, known_plan, phases


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("speed", [1.0, 0.07])
def test_no_family_jumps(family, speed):
    plan = known_plan(Slowed(SAMPLES[family](), speed))
    assert jumps(plan, plan.tick) == []


@pytest.mark.parametrize(
    ("name", "size", "unit"),
    [("position", 1e-3, "rad"), ("velocity", 0.05, "rad/s"), ("acceleration", 0.5, "")],
)
def test_a_piece_that_does_not_join_is_named(name, size, unit):
    motion = phases()
    states = getattr(motion, name).copy()
    states[2, 1] += size
    (sentence,) = [
        text
        for text in violations(known_plan(replace(motion, **{name: states})))
        if text.startswith(f"elbow: {name} jumps by more than ")
    ]
    assert unit in sentence
    value, time = (float(part.split()[0]) for part in (sentence.split("than ")[1], sentence.split("at ")[-1]))
    assert 0.5 * size < value <= size
    assert abs(time - motion.start[2]) < known_plan().tick
