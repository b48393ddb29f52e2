"""A plan's page: what is drawn and printed is what the trajectory does, and what is beyond is marked."""

import re
from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.robot import Limits
from exidyn.identification.document.text import brief_text, text
from exidyn.identification.effects import Payload
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.plans.plan_check import limit_use, nominal_torque, violations
from exidyn.trajectories.plans.plan_page import joint_plot, plan_curves, plan_page
from exidyn.trajectories.plans.plan_summary import plan_document, plan_facts
from exidyn.trajectories.trajectory import State

from ...parts.pages.report_pages import Page, dots_of, points_of
from ...parts.plans.plans import SAMPLES, known_plan
from ...parts.small import two_joints

BODY = (("M", 20.0), ("MX", 2.0), ("MY", 0.0), ("MZ", 1.0))


@pytest.fixture
def plan():
    """Joint 1: 2 sin(w t) with w = 2 rad/s, joint 2: a tenth of it; limits 3 rad/s, 12 rad/s^2."""
    sine = np.array([[1.4], [0.14]])
    motion = Fourier(np.pi, np.array([0.5, 0.0]), sine, np.zeros((2, 1)), 2)
    return known_plan(motion, payload_pair=False)


def beyond(plan):
    """Joint 1 three times as far: 4.2 rad and 8.4 rad/s."""
    return replace(plan, trajectory=plan.trajectory.scaled(3.0))


def paths(drawn, style):
    return [attrs["d"] for tag, attrs in drawn.elements if tag == "path" and attrs.get("class") == style]


def test_shares_are_of_the_exact_extremes(plan):
    position, velocity, acceleration, jerk = limit_use(plan)
    np.testing.assert_allclose(position.share, [1.9 / 2.5, 0.14 / 2.5])
    np.testing.assert_allclose(velocity.share, [2.8 / 3.0, 0.28 / 3.0])
    np.testing.assert_allclose(acceleration.share, [5.6 / 12.0, 0.56 / 12.0])
    np.testing.assert_allclose(jerk.share, [11.2 / 200.0, 1.12 / 200.0])


def test_shares_know_directions_and_middles(plan):
    slower = replace(
        plan.limits, velocity_lower=np.array([-2.0, -3.0]), position_lower=np.array([-1.0, -2.5])
    )
    position, velocity, *_ = limit_use(replace(plan, limits=slower))
    assert velocity.share[0] == pytest.approx(1.4)
    assert velocity.violated.tolist() == [True, False]
    # the middle of -1 to 2.5 is 0.75, and the motion goes down to -0.9
    assert position.share[0] == pytest.approx(1.65 / 1.75)
    for use in limit_use(replace(plan, limits=Limits.none(2))):
        assert np.all(np.isnan(use.share))
        assert not use.violated.any()


@pytest.mark.parametrize("family", SAMPLES)
def test_lines_pass_through_every_tick(family):
    plan = known_plan(SAMPLES[family]())
    curves = plan_curves(plan)
    assert [curve.use.name for curve in curves] == ["position", "velocity", "acceleration", "jerk"]
    for joint in range(2):
        drawn = Page(joint_plot(plan, joint, curves, columns=10_000))
        for curve, steps in zip(curves, paths(drawn, "moved")[1:], strict=True):  # the first is the legend's
            values = curve.runs[0][1][:, joint]
            heights = points_of(steps)[:, 1]
            assert len(heights) == len(values)
            slope, level = np.polyfit(heights, values, 1)
            assert slope < 0.0
            # a tenth of a pixel, of the whole panel's 84 with its limits in it
            size = max(np.ptp(values), curve.use.upper[joint] - curve.use.lower[joint])
            assert np.abs(slope * heights + level - values).max() < size / 500


def test_what_is_beyond_is_marked_where_it_is(plan):
    far = beyond(plan)
    drawn = Page(joint_plot(far, 0, plan_curves(far), columns=10_000))
    assert "beyond the limit" in drawn.words
    dots = [dots_of(steps) for steps in paths(drawn, "beyond")[1:] if steps]  # the first is the legend's
    assert len(dots) == 3  # position, velocity and acceleration, not jerk
    velocity = far.trajectory.every(far.tick).velocity[:, 0]
    assert len(dots[1]) == np.sum(np.abs(velocity) > 3.0) + 2  # and the two extremes
    assert "280.0 %" in re.sub(r"\s+", " ", drawn.words)
    drawn = Page(joint_plot(plan, 0, plan_curves(plan), columns=10_000))
    assert not [steps for steps in paths(drawn, "beyond") if steps]
    limits = [points_of(steps)[:, 1] for steps in paths(drawn, "limit")[1:]]
    assert len(limits) == 8
    velocity, (lower, upper) = points_of(paths(drawn, "moved")[2])[:, 1], limits[2:4]
    assert np.ptp(lower) == np.ptp(upper) == 0
    assert np.ptp(velocity) / (lower[0] - upper[0]) == pytest.approx(2.8 / 3.0, abs=2e-3)


def test_a_peak_between_ticks_is_marked_too():
    # 1.5 ms into a tick of 4 ms the velocity turns, at 3.0000225 rad/s, and no tick sees more than 3
    jerk, rise = 20.0, 0.0015
    start = State(np.zeros(2), np.array([3.0, 0.0]), np.array([jerk * rise, 0.0]))
    motion = Phases.of_jerks(start, np.array([0.004]), np.array([[-jerk, 0.0]]))
    plan = known_plan(motion)
    ticks = plan.trajectory.every(plan.tick).velocity[:, 0]
    assert ticks.max() == 3.0
    (mark,) = (dots_of(s) for s in paths(Page(joint_plot(plan, 0, plan_curves(plan))), "beyond")[1:] if s)
    assert len(mark) == 1


def test_torque_is_that_of_the_model_and_has_its_own_panel(plan):
    model = two_joints.model()
    torque = nominal_torque(plan, model)
    (run,) = torque.runs
    states = plan.trajectory.every(plan.tick)
    expected = model.torque(states.motion(), model.nominal_values)
    np.testing.assert_allclose(run[1], expected)
    np.testing.assert_allclose(torque.use.upper, 200.0)
    assert np.all(torque.use.reached.upper >= expected.max(axis=0))
    drawn = Page(joint_plot(plan, 0, plan_curves(plan, torque)))
    assert "torque [N m]" in drawn.words
    assert len([tag for tag, attrs in drawn.elements if attrs.get("class") == "frame"]) == 5


def test_a_payload_pair_has_two_torques_and_the_worse_counts(plan):
    model = two_joints.model(Payload("L", BODY))
    torque = nominal_torque(replace(plan, payload_pair=True), model)
    assert [name for name, _ in torque.runs] == ["unloaded", "L"]
    empty, full = (np.abs(values).max(axis=0) for _, values in torque.runs)
    assert np.all(full > empty)
    size = np.maximum(torque.use.reached.upper, -torque.use.reached.lower)
    assert np.all(size >= full)
    np.testing.assert_allclose(size, full, rtol=1e-3)
    drawn = Page(joint_plot(plan, 1, plan_curves(plan, torque)))
    assert "with payload L" in drawn.words
    assert len(paths(drawn, "loaded")) == 2  # in the legend and in the plot


def test_violations_name_joint_limit_and_torque(plan):
    assert violations(plan) == []
    weak = replace(plan, limits=replace(plan.limits, torque=np.array([1.0, 200.0])))
    (low, *_) = violations(weak, nominal_torque(weak, two_joints.model()))
    assert low.startswith("shoulder: torque at ")
    text = violations(beyond(plan))
    assert any(s.startswith("shoulder: velocity at ") and "8.4" in s and "limit 3 rad/s" in s for s in text)
    assert not any(s.startswith("elbow") for s in text)


def test_unknown_limits_are_not_violated_and_stops_still_told(plan):
    free = Limits.none(2)
    assert violations(replace(plan, limits=free)) == []
    walls = replace(free, position_lower=np.full(2, -1.1), position_upper=np.full(2, 2.1))
    assert violations(replace(plan, limits=walls)) == []
    start = State(np.zeros(2), np.array([3.0, 0.0]), np.zeros(2))
    fast = Phases.of_jerks(start, np.array([0.2]), np.zeros((1, 2)))
    (text,) = violations(replace(plan, trajectory=fast, limits=walls))
    assert "shoulder: a stop begun at" in text


def test_page_needs_nothing_else_and_closes_its_tags(plan):
    text = plan_page(plan, violations(plan))
    page = Page(text.removeprefix("<!doctype html>"))
    assert not [attrs for _, attrs in page.elements if "src" in attrs]
    assert all(attrs.get("href", "#").startswith("#") for _, attrs in page.elements)
    assert "<script" not in text
    assert "http" not in text
    for words in ("Keeps to all known limits", "shoulder", "elbow", "no wind", "0.3333", plan.robot_hash):
        assert words in page.words


def test_page_reports_what_it_did_not_look_at(plan):
    pair = replace(plan, payload_pair=True)
    bare, known = two_joints.model(), two_joints.model(Payload("L", BODY))
    for one, torque, words in (
        (plan, None, "Not checked here: collisions; torque, which needs the robot."),
        (plan, nominal_torque(plan, bare), "Not checked here: collisions."),
        (pair, nominal_torque(pair, bare), "collisions; torque of the loaded run, since"),
        (pair, nominal_torque(pair, known), "Not checked here: collisions."),
    ):
        assert words in plan_page(one, (), torque)


def test_page_reports_what_is_beyond_and_colours_it(plan):
    far = beyond(plan)
    page = Page(plan_page(far, violations(far)).removeprefix("<!doctype html>"))
    assert "Exceeds limits: do not run it." in page.words
    row = page.row("limits", "shoulder")
    cells = "shoulder|rad|-3.70 .. 4.70|-2.50 .. 2.50|280.0|140.0|16.8"
    assert [cell for cell, _ in row] == cells.split("|")
    styles = [attrs.get("class") for tag, attrs in page.elements if tag == "td"]
    assert styles.count("bad") == 3


def test_page_escapes_what_people_wrote(plan):
    text = plan_page(
        replace(plan, robot="<b>", joints=("<i>", "&"), assumed=("1 < 2",), details={"<u>": "<s>"})
    )
    for tag in ("<b>", "<i>", "<u>", "<s>"):
        assert tag not in text
    assert "1 &lt; 2" in text


def test_unlimited_joints_are_reported_and_units_stated(plan):
    jerky = replace(plan, limits=replace(plan.limits, jerk=np.array([np.inf, 200.0])), units=("rad", "m"))
    page = Page(plan_page(jerky).removeprefix("<!doctype html>"))
    for words in (
        "No jerk limit is known for shoulder.",
        "no limit",
        "jerk [rad/s³]",
        "jerk [m/s³]",
        "time [s]",
    ):
        assert words in page.words


def test_summary_has_the_numbers_and_no_wide_line(plan):
    far = plan_document(beyond(plan), limit_use(beyond(plan)), violations(beyond(plan)), ["slow"])
    for page in (text(far), brief_text(far, 25)):
        assert max(map(len, page.splitlines())) <= 80
        assert re.search(r"shoulder +rad +-3.70 .. 4.70 +-2.50 .. 2.50 +280.0 +140.0 +16.8$", page, re.M)
        assert "BEYOND: shoulder: velocity" in page
        assert "- slow\n" in page
        assert page.lstrip().startswith("Motion for two joints: 6.28319 s, fourier\n")
    inside = brief_text(plan_document(plan, limit_use(plan)), 25)
    assert "Keeps to all known limits (at most 93.3 % of velocity, on shoulder)" in inside


def test_margins_are_those_of_joints_that_the_arm_has(plan):
    margins = {"position": 0.05, "slide": 0.01}
    turning = replace(plan, margins=margins, units=("rad", "rad"))
    assert plan_facts(turning)["safety margins"] == "position 0.05 rad"
    sliding = replace(plan, margins=margins, units=("m", "rad"))
    assert plan_facts(sliding)["safety margins"] == "position 0.05 rad, slide 0.01 m"
    facts = plan_facts(replace(plan, payload_pair=True, details={"period": 9.5}))
    assert facts["to be run"] == "twice, unloaded and loaded, a command every 4 ms"
    assert facts["period"] == "9.500 s"
