"""Scores of answers about real arms: items named, equal physics, false names, and changes for nothing."""

from types import SimpleNamespace

import pytest

pytest.importorskip("mujoco")

from parts.simulator.answers import said  # noqa: E402
from parts.simulator.concealed_gap import summary  # noqa: E402
from parts.simulator.physics import Item  # noqa: E402
from parts.simulator.score import score  # noqa: E402

from .test_real_arms import FILE  # noqa: E402

DELAY = Item("delay", (0, 1), {"seconds": 0.02})
MASS = Item("mass", (1,), {"factor": 1.5})


def answer(findings=(), servos=(), changes=()):
    """The result of a gap, as far as the benchmark reads it."""
    written = tuple(SimpleNamespace(where=where, attribute=name, old=1.0, new=2.0) for where, name in changes)
    file = SimpleNamespace(text=FILE.encode(), changes=written)
    named = tuple(SimpleNamespace(effect=effect, joints=joints) for effect, joints in findings)
    diagnosis = SimpleNamespace(joints=("shoulder", "elbow"))
    changed = tuple(SimpleNamespace(joint=j, quantity=name, old=1.0, new=2.0) for j, name in servos)
    attached = SimpleNamespace(text=FILE.encode(), changes=(), arm=None, attaches=False)
    result = SimpleNamespace(
        diagnosis=diagnosis,
        findings=named,
        file=file,
        attached=attached,
        servos=changed,
        commands="position",
        held=False,
    )
    return said(result, FILE)


def test_a_delay_is_named_if_it_is_named_on_all_its_joints():
    assert score([DELAY], answer(servos=[(0, "delay"), (1, "delay")]), True).named == (("delay", (0, 1)),)
    half = score([DELAY], answer(servos=[(0, "delay")]), True)
    assert half.named == half.false == ()
    assert score([DELAY], answer([("time_delay", ())]), True).named == (("delay", (0, 1)),)


def test_a_mass_may_be_named_on_the_body_of_a_neighbor():
    for change in (("body 'lower'", "mass"), ("body 'upper'", "fullinertia xx"), ("body 'lower'", "pos x")):
        assert score([MASS], answer(changes=[change]), True).named
    assert not score([MASS], answer(changes=[("joint 'elbow'", "damping")]), True).named


def test_damping_of_a_servo_is_that_of_its_joint_in_logs_of_commands_alone():
    item, damping = Item("kv", (1,), {"factor": 0.7}), answer(changes=[("joint 'elbow'", "damping")])
    assert not score([item], damping, with_torque=True).named
    assert score([item], damping, with_torque=False).named
    viscous = Item("viscous", (1,), {"damping": 1.0})
    assert score([viscous], damping, with_torque=True).named
    assert not score([viscous], answer(servos=[(1, "kv")]), with_torque=True).named
    assert score([viscous], answer(servos=[(1, "kv")]), with_torque=False).named


def test_names_that_were_not_concealed_are_false():
    items = [Item("cable", (1,), {}), Item("kp", (0,), {})]
    findings = [("joint_spring", (1,)), ("torque_ripple", (1,)), ("torque_ripple", (0,))]
    scores = score(items, answer(findings, servos=[(0, "kp"), (1, "kp")]), True)
    assert len(scores.named) == 2
    assert scores.false == (("kp", 1), ("torque_ripple", 0))
    assert score([], answer([("base_tilt", ())]), True).false == (("base_tilt", -1),)


def test_servos_are_changes_of_the_file_once():
    assert len(answer(servos=[(0, "kp")], changes=[("joint 'elbow'", "damping")]).changed) == 2
    listed = answer(servos=[(0, "kp")], changes=[("actuator 'a'", "kp"), ("joint 'elbow'", "damping")])
    assert len(listed.changed) == 2


def test_the_summary_counts_refusals_and_excludes_controls_from_medians():
    item = {"concealed": [("kp", (0,), {})], "named": [("kp", (0,))], "false": [], "file_worse": False}
    closed = item | {"gap_left_file": 0.3, "gap_left_attached": 0.1}
    control = {"concealed": [], "named": [], "false": [], "file_worse": True, "changed": [["a", "b"]]}
    refused = {"concealed": [("kp", (0,), {})], "refused": "RobotError: no"}
    figures = summary([closed, control, refused])
    assert figures["named_percent"] == 50.0
    assert (figures["refused"], figures["changed_for_nothing"], figures["file_worse_than_original"]) == (
        1,
        1,
        1,
    )
    assert figures["gap_left_file"] == 0.3
