"""Trajectory files: exact both ways for every family; a bad one is refused by name of file and key."""

import re
from dataclasses import dataclass, fields, replace

import numpy as np
import pytest

from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.errors import NotATrajectory
from exidyn.trajectories.families import FAMILIES
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.plans import plan_file
from exidyn.trajectories.plans.plan import Plan, fits, model_differences, robot_differences
from exidyn.trajectories.plans.plan_file import parse_plan, plan_text, read_plan, write_plan
from exidyn.trajectories.trajectory import Trajectory

from ...parts.plans.plans import SAMPLES, fourier, known_plan, phases
from ...parts.small import two_joints


def same(one, other):
    """Whether two values are the same to the last bit, whatever they are made of."""
    if isinstance(one, np.ndarray):
        return other.dtype == one.dtype and np.array_equal(one, other, equal_nan=True)
    if isinstance(one, Trajectory | Limits | Plan):
        return type(one) is type(other) and all(
            same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one)
        )
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return type(one) is type(other) and (one == other or (one != one and other != other))


@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_comes_back_to_the_last_bit(family, tmp_path):
    plan = known_plan(SAMPLES[family]())
    assert type(plan.trajectory) is FAMILIES[family]
    write_plan(plan, tmp_path / "plan.toml")
    assert same(read_plan(tmp_path / "plan.toml"), plan)
    assert [path.name for path in tmp_path.iterdir()] == ["plan.toml"]


@dataclass(frozen=True, eq=False)
class Made(Fourier):
    """A family of this test, with every kind of field."""

    inner: Trajectory | None = None
    parts: tuple[Trajectory, ...] = ()
    joints: tuple[str, ...] = ()
    order: tuple[int, ...] = ()
    label: str = "made"
    forward: bool = True
    unit: float = 1.0


@pytest.fixture
def made(monkeypatch):
    monkeypatch.setitem(plan_file.FAMILIES, "made", Made)
    base = {f.name: getattr(fourier(), f.name) for f in fields(Fourier)}
    inside = Made(**base, parts=(phases(3),))
    return Made(
        **base, inner=fourier(3), parts=(phases(), inside, fourier(1, 4)), joints=("a", "b"), order=(1, 0)
    )


def test_a_new_family_costs_one_line(made):
    text = plan_text(known_plan(made))
    assert "[[trajectory.parts.parts]]" in text
    assert same(parse_plan(text).trajectory, made)


def test_a_family_that_is_in_no_table_cannot_be_written():
    with pytest.raises(LookupError, match="called 'Made'. Valid: chirp, fourier"):
        plan_text(known_plan(Made(**{f.name: getattr(fourier(), f.name) for f in fields(Fourier)})))


def test_infinite_limits_no_criterion_and_line_ends_come_back():
    plan = replace(known_plan(), limits=Limits.none(2), criterion="", reached=float("nan"), details={})
    for ends in ("\n", "\r\n"):
        assert same(parse_plan(plan_text(plan).replace("\n", ends)), plan)


def test_defaults_are_implied():
    text = plan_text(known_plan())
    for key in ("checksum", "criterion", "reached", "seed", "tick", "payload_pair", "assumed", "periods"):
        text = re.sub(rf"^{key} = .*\n", "", text, flags=re.M)
    plan = parse_plan(text)
    assert (plan.criterion, plan.seed, plan.payload_pair, plan.assumed) == ("", 0, False, ())
    assert plan.trajectory.periods == 1


@pytest.mark.parametrize("family", FAMILIES)
def test_a_file_cut_off_anywhere_is_refused(family):
    text = plan_text(known_plan(SAMPLES[family]())).rstrip()
    for end in np.linspace(0, len(text) - 1, 150).astype(int):
        with pytest.raises(NotATrajectory, match="cut off|no key 'kind'|kind = |no key 'family'|family '"):
            parse_plan(text[:end])


@pytest.mark.parametrize(
    ("found", "put", "message"),
    [
        ("format = 1", "format = 2", "format 2; this version reads 1; update exidyn"),
        (
            "format = 1",
            "format = 0",
            "format 0; this version reads 1; write it anew with exidyn excite ROBOT",
        ),
        ('kind = "trajectory"', 'kind = "robot"', "not a trajectory file: kind = 'robot'"),
        ('"fourier"', '"furier"', r"trajectory: family 'furier'; expected one of: chirp, fourier"),
        ('family = "fourier"', "", r"trajectory: no key 'family'; expected one of: chirp"),
        ("period = 3.3333333333333335", "", r"trajectory: key 'period' is missing; was the file"),
        (
            "period = ",
            "periode = ",
            r"trajectory: fourier: unknown key 'periode'. Valid keys: centre, cosine, fam",
        ),
        ("periods = 2", "periods = 2.5", r"trajectory: periods: expected whole number; found 2.5"),
        ("periods = 2", "periods = 0", r"trajectory: Fourier: period 3.33333 s, 0 times"),
        ("centre = [0.1", "centre = [nan", r"centre: expected a number .*; found nan at \[0\]"),
        ("centre = [0.1, ", "centre = [", r"trajectory: Fourier: centre \(1,\), sine \(2, 5\)"),
        ("  [0.01257302210933933, ", "  [", r"trajectory: sine: expected rows of one length"),
        ("tick = 0.004", "tick = 0.0", "tick is 0 s, expected above 0"),
        ("seed = 12", "sead = 12", "unknown key 'sead'. Valid keys: assumed, checksum, criterion, details"),
        ('units = ["rad", "rad"]', 'units = ["rad", "deg"]', "units: 'deg' is not one of rad, m"),
        (
            'units = ["rad", "rad"]',
            'units = ["rad"]',
            "units has 1 entries, and the trajectory moves 2 joints",
        ),
        ('joints = ["shoulder", "elbow"]', 'joints = "shoulder"', "joints: expected list; found 'shoulder'"),
        ('["shoulder", "elbow"]', '["a", "b", "c"]', r"\[limits\] position_lower: 2 values, expected 3"),
        ("velocity = [3.0, 3.0]", "velocity = [3.0, nan]", r"\[limits\] velocity\[1\]: expected a number"),
        ("jerk = [200.0, 200.0]", "", r"\[limits\]: key 'jerk' is missing"),
        ("jerk = [200.0, 200.0]", "jerk = [200.0, -1.0]", r"\[limits\]: joint 2: jerk limit -1 rad/s\^3; no"),
        ("velocity_lower = [-3.0", "velocity_lower = [3.0", r"\[limits\]: joint 1: backward velocity limit"),
        ("tick = 0.004", "tick = 1e-12", "6.66667 s with a command every 1e-12 s are 6.67e.12 commands"),
        ("[margins]", "[margin]", "unknown key 'margin'"),
    ],
)
def test_a_wrong_file_is_refused_in_one_sentence(found, put, message, tmp_path):
    text = plan_text(known_plan())
    assert found in text
    (tmp_path / "bad.toml").write_text(text.replace(found, put, 1), encoding="utf-8")
    with pytest.raises(NotATrajectory, match=message) as refused:
        read_plan(tmp_path / "bad.toml")
    assert str(refused.value).startswith(f"{tmp_path / 'bad.toml'}: ")


@pytest.mark.parametrize(
    ("name", "message"),
    [("picture.png", "not a text file"), ("none.toml", "No such file"), (".", "directory")],
)
def test_what_is_no_text_or_no_file_is_refused(tmp_path, name, message):
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\xff")
    with pytest.raises(NotATrajectory, match=message):
        read_plan(tmp_path / name)


def test_a_plan_needs_what_its_trajectory_moves():
    with pytest.raises(
        NotATrajectory, match=r"limits.position_lower has 3 entries, and the .* moves 2 joints"
    ):
        replace(known_plan(), limits=Limits.none(3))


def test_other_masses_change_the_model_and_not_the_robot():
    assert fits(known_plan(), two_joints.model()) == []
    model = two_joints.model(gain=2 * two_joints.GAIN)
    assert robot_differences(known_plan(), model.robot) == []
    (text,) = model_differences(known_plan(), model)
    assert "not the one of the plan" in text
    assert fits(known_plan(), model) == [text]


def test_other_limits_geometry_and_joints_are_reported():
    robot = two_joints.arm()
    slower = replace(robot.limits, velocity=np.array([3.0, 2.0]))
    (text,) = robot_differences(known_plan(), replace(robot, limits=slower))
    assert text == "limit velocity of elbow is 2; it was 3 when the plan was made"
    longer = robot.kinematics.copy()
    longer.jointPlacements[2].translation = np.array([0.5, 0.0, 0.0])
    (text,) = robot_differences(known_plan(), replace(robot, kinematics=longer))
    assert "another geometry" in text
    plan = replace(known_plan(), joints=("A1", "A2"))
    (text,) = robot_differences(plan, robot)
    assert text == "the plan is for the joints A1, A2 of two joints; two joints has shoulder, elbow"


def test_a_changed_digit_is_another_motion_and_refused():
    text = plan_text(known_plan())
    place = text.index("0.", text.index("[trajectory]")) + 2
    changed = text[:place] + ("7" if text[place] != "7" else "3") + text[place + 1 :]
    with pytest.raises(NotATrajectory, match="has changed since exidyn wrote it.*remove the line"):
        parse_plan(changed)
    meant = parse_plan(re.sub(r'checksum = ".*"\n', "", changed))
    assert not same(meant.trajectory, known_plan().trajectory)
    assert meant.edited


@pytest.mark.parametrize("line", ["", 'checksum="0123456789abcdef"\n', "checksum = '0123456789abcdef'\n"])
def test_a_file_without_a_checksum_that_exidyn_wrote_is_marked_and_gets_none(line):
    text = plan_text(known_plan())
    assert not parse_plan(text).edited
    plan = parse_plan(re.sub(r'checksum = ".*"\n', line, text))
    assert plan.edited
    assert "checksum" not in plan_text(plan)
    assert same(parse_plan(plan_text(plan)), plan)
