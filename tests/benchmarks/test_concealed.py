"""The plant, the cases and the scores of the concealed benchmark."""

import os
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identify.recordings.importers import import_source

os.environ["NUMBA_DISABLE_JIT"] = "1"  # small arms and short runs do not pay for compiling
sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import concealed_plant
import concealed_record
from concealed_answers import Guess, Truth, read_answer
from concealed_arms import ARMS, EARTH, NO_BALANCER, Arm, Limits, Tool, chain
from concealed_body import inverse_dynamics, turn, weld
from concealed_case import concealed_set, draw, stands
from concealed_effects import VOCABULARY, places
from concealed_forces import gyration, misread, windup
from concealed_friction import plain_friction, rub
from concealed_half_way import half_way
from concealed_mass import mass_matrix, solve
from concealed_motion import derivatives, smooth
from concealed_outside import OUTSIDE
from concealed_plant import EVERY, RATE, SETTLE, STEP, at_rest, run
from concealed_record import COLOURED, DISTURBING, PLANS, WHITE, Run, coloured, drags, record, rms
from concealed_robot import honest
from concealed_score import Pair, figures, sensitivity, simulated_share
from concealed_write import urdf, write_case


def small_arm(joints: int = 2, lean: int = 0) -> Arm:
    """An arm of one or two equal joints, the second's axis leaning by quarter turns."""
    ones = np.ones(joints)
    body = chain(
        [1] + [lean] * (joints - 1),
        [(0.0, 0.0, 0.3)] + [(0.5, 0.0, 0.1)] * (joints - 1),
        [4.0] * joints,
        [(0.25, 0.02, 0.05)] * joints,
        [(0.05, 0.15, 0.15)] * joints,
    )
    limits = Limits(-3 * ones, 3 * ones, 2 * ones, 8 * ones, 100 * ones)
    return Arm(
        name="small", body=body, limits=limits, home=0.0 * ones, gain=10 * ones, gear=100 * ones, rotor=ones,
        viscous=5 * ones, coulomb=4 * ones, encoder=5e-6 * ones, current=0.01 * ones, floor=0.2 * ones,
        tool=Tool(1.0, np.array([0.0, 0.0, 0.1]), np.full(3, 0.1)), warm=True, balancer=NO_BALANCER,
    )  # fmt: skip


def sticking(arm: Arm, seed: int = 0):
    """A sound robot of an arm, with bristles in its joints and all terms believed."""
    robot = honest(arm, np.random.default_rng(seed))
    return robot.with_friction(creep=np.zeros(arm.joints), coulomb=np.array(arm.coulomb))


@cache
def sound(name: str):
    """A robot with nothing wrong."""
    arm = ARMS[name]()
    return replace(honest(arm, np.random.default_rng(3)), peak=0.5 * arm.limits.torque)


def swing(joints: int, seconds: float) -> np.ndarray:
    """From rest to rest, two joints in opposite ways, (3, s, n)."""
    time = np.arange(round(seconds / STEP)) * STEP
    return derivatives(np.outer(smooth(time / seconds), 0.6 * np.array([1.0, -1.0])[:joints]))


def quiet(path: np.ndarray) -> np.ndarray:
    """No disturbance of a path."""
    return np.zeros((path.shape[1] + round(SETTLE / STEP), path.shape[2]))


@pytest.mark.parametrize("name", ARMS)
def test_bodies_move_as_pinocchio_says(name):
    robot = sound(name)
    body, n = robot.machine.body, robot.arm.joints
    model = pin.buildModelFromXML(urdf(replace(robot, belief=robot.belief._replace(body=body))))
    data = model.createData()
    position, velocity, acceleration = np.random.default_rng(1).normal(size=(3, n))
    turned, matrix, torque, found = np.empty((n, 3, 3)), np.empty((n, n)), np.empty(n), np.empty(n)
    turn(body.rotation, position, turned)
    inverse_dynamics(body, turned, velocity, acceleration, -EARTH, np.zeros(3), torque)
    expected = pin.rnea(model, data, position, velocity, acceleration)
    np.testing.assert_allclose(torque, expected, atol=1e-8 * np.max(np.abs(expected)))
    mass_matrix(body, turned, matrix)
    crba = pin.crba(model, data, position)
    np.testing.assert_allclose(matrix, np.triu(crba) + np.triu(crba, 1).T, atol=1e-8 * np.max(crba))
    inertia = matrix.copy()
    solve(matrix, torque, found)
    np.testing.assert_allclose(inertia @ found, torque)


def test_a_force_on_the_flange_is_felt_through_the_jacobian():
    robot = sound("ur10like")
    body, n = robot.machine.body, 6
    model = pin.buildModelFromXML(urdf(replace(robot, belief=robot.belief._replace(body=body))))
    position, force = np.random.default_rng(2).normal(size=n), np.array([3.0, -5.0, 7.0])
    turned, felt, free = np.empty((n, 3, 3)), np.empty(n), np.empty(n)
    turn(body.rotation, position, turned)
    for pull, torque in ((force, felt), (np.zeros(3), free)):
        inverse_dynamics(body, turned, np.zeros(n), np.zeros(n), -EARTH, pull, torque)
    jacobian = pin.computeJointJacobian(model, model.createData(), position, n)
    np.testing.assert_allclose(felt - free, -(jacobian[:3].T @ force), atol=1e-9)


def test_a_welded_body_keeps_mass_and_moments():
    body = small_arm(1).body
    heavier = weld(body, 0, 2.0, np.array([0.0, 0.3, 0.0]), 0.01 * np.eye(3))
    back = weld(heavier, 0, -2.0, np.array([0.0, 0.3, 0.0]), -0.01 * np.eye(3))
    assert heavier.mass[0] == 6.0
    np.testing.assert_allclose(back.com, body.com, atol=1e-12)
    np.testing.assert_allclose(back.inertia, body.inertia, atol=1e-12)


def test_without_an_effect_currents_are_inverse_dynamics():
    robot = sticking(small_arm())
    path = swing(2, 0.8)
    fine = robot.machine._replace(count=np.full(2, 1e-9))  # else drives chatter between two counts
    log = run(fine, path, quiet(path), np.full(2, 35.0))
    model = pin.buildModelFromXML(urdf(replace(robot, belief=robot.belief._replace(body=robot.machine.body))))
    data, friction = model.createData(), robot.machine.friction
    velocity = np.gradient(log.link, 1 / RATE, axis=0)
    acceleration = np.gradient(velocity, 1 / RATE, axis=0)
    rigid = np.array(
        [pin.rnea(model, data, *state) for state in zip(log.link, velocity, acceleration, strict=True)]
    )
    expected = rigid + acceleration * np.diag(robot.machine.rotor) - robot.machine.offset
    warmed = np.exp(-friction.thinning * (log.temperature - 35.0))
    expected += velocity * np.diag(friction.viscous) * warmed + np.sign(velocity) * friction.coulomb
    sliding = np.abs(velocity) > 0.2
    sliding[:20] = sliding[-20:] = False
    assert np.sqrt(np.mean((log.command - expected)[sliding] ** 2)) < 0.25 * robot.arm.floor[0]
    assert np.ptp(log.command) > 100 * robot.arm.floor[0]


def test_two_masses_keep_energy_and_momentum():
    robot = sticking(small_arm(1))
    free = robot.machine._replace(
        body=robot.machine.body._replace(gravity=np.zeros(3)),
        friction=plain_friction(np.zeros(1), np.zeros(1), np.full(1, 1e-5), np.zeros(1), np.ones(1)),
        stiffness=np.array([900.0]), offset=np.zeros(1), push=np.zeros((1, 4)),
    )  # fmt: skip
    path = np.zeros((3, 1000, 1))
    kick = quiet(path)
    start = round(SETTLE / STEP)
    kick[start : start + 100] = 30.0  # 1.5 N m s
    log = run(free, path, kick, np.full(1, 35.0))
    turned, link = np.empty((1, 3, 3)), np.empty((1, 1))
    turn(free.body.rotation, np.zeros(1), turned)
    mass_matrix(free.body, turned, link)
    # Central differences of samples that leap-frog: exact momentum, energy to the order of the step squared.
    spin, speed = (np.gradient(x, 1 / RATE, axis=0)[60:-5, 0] for x in (log.position, log.link))
    twist = (log.position - log.link)[60:-5, 0]
    momentum = spin * free.rotor[0, 0] + speed * link[0, 0]
    np.testing.assert_allclose(momentum, 1.5, rtol=1e-6)
    kinetic = 0.5 * (spin**2 * free.rotor[0, 0] + speed**2 * link[0, 0])
    energy = kinetic + 450.0 * twist**2
    np.testing.assert_allclose(energy, np.mean(energy), rtol=0.02)
    assert np.ptp(kinetic) > 0.1 * np.mean(energy)  # it does swing


def test_what_hangs_on_the_link_winds_the_transmission_up():
    robot = sticking(small_arm(1))
    soft = robot.machine._replace(stiffness=np.array([2000.0]), loss=np.array([60.0]), offset=np.zeros(1))
    tied = soft._replace(cable=np.array([[30.0, 0.0, -0.2]]))
    path = np.zeros((3, 200, 1))
    twist = [np.subtract(*run(one, path, quiet(path), np.full(1, 35.0))[:2])[-1, 0] for one in (soft, tied)]
    assert 2000.0 * (twist[1] - twist[0]) == pytest.approx(30.0 * 0.2, rel=0.05)


def test_a_dead_zone_passes_no_torque_and_then_a_spring():
    machine = sticking(small_arm(1)).machine._replace(gap=np.array([0.002]), stiffness=np.array([1e4]))
    assert windup(machine, 0, 0.0019, 5.0) == 0.0
    assert windup(machine, 0, 0.003, 0.0) == pytest.approx(10.0)
    assert windup(machine, 0, -0.003, 0.0) == pytest.approx(-10.0)
    path = swing(1, 0.6)
    loose = machine._replace(stiffness=np.array([2e4]), loss=np.array([20.0]))
    twist = np.subtract(*run(loose, path, quiet(path), np.full(1, 35.0))[:2])
    assert np.max(twist) > 0.002  # the motor leans on either side of its teeth
    assert np.min(twist) > -0.01


def test_bristles_give_way_at_dry_friction_and_hold_before():
    robot = sticking(small_arm(1))
    friction, torque = robot.machine.friction, np.zeros(1)
    bristles, blocks, still = np.zeros(2), np.zeros((1, 4)), np.zeros(1)
    for _ in range(400):
        rub(friction, still, np.array([0.2]), still, np.full(1, 35.0), bristles, blocks, STEP, torque)
    assert torque[0] == pytest.approx(friction.coulomb[0] + 0.2 * friction.viscous[0, 0], rel=1e-3)
    rub(friction, still, still, still, np.full(1, 35.0), bristles, blocks, STEP, torque)
    assert torque[0] == pytest.approx(friction.coulomb[0], rel=1e-3)


def test_a_drive_holds_a_sticking_arm_without_hunting():
    robot = sticking(small_arm(1))
    path = np.zeros((3, 400, 1))
    log = run(robot.machine, path, quiet(path), np.full(1, 35.0))
    assert np.ptp(log.command[50:], axis=0).max() < 0.1 * robot.arm.floor[0]


def test_noise_has_the_size_that_truth_states():
    assert WHITE**2 + COLOURED**2 + DISTURBING**2 == pytest.approx(1.0, abs=0.01)
    noise = coloured(0.85, 40000, 2, np.random.default_rng(0))
    assert np.std(noise) == pytest.approx(1.0, abs=0.05)
    assert np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1] == pytest.approx(0.85, abs=0.02)


@pytest.mark.parametrize("name", [*VOCABULARY, *OUTSIDE])
def test_an_effect_changes_the_robot_and_tells_no_owner(name):
    effect = (VOCABULARY | OUTSIDE)[name]
    robot = sound(list(ARMS)[len(name) % len(ARMS)])
    joint = places(name, robot)[-1]
    concealed = effect(robot, joint, 1.0, np.random.default_rng(4))
    again = effect(robot, joint, 1.0, np.random.default_rng(4))
    assert all(0 <= place < robot.arm.joints for place in concealed.joints)
    assert repr(concealed) == repr(again)
    real = (concealed.robot.machine, concealed.robot.recorder)
    assert repr(real) != repr((concealed.sound.machine, concealed.sound.recorder))
    # A tool that its owner knows of is believed with and without the effect.
    believed, before = concealed.robot.belief, concealed.sound.belief
    np.testing.assert_array_equal(believed.body.mass, before.body.mass)
    np.testing.assert_array_equal(believed.gain, before.gain)
    for term, there in believed.terms.items():  # a term may be left out, none is given away
        assert np.all(before.terms[term] >= there)


@pytest.fixture
def at_once(monkeypatch):
    """Recordings of a tenth of a second, drives not settled before."""
    monkeypatch.setattr(concealed_plant, "SETTLE", 0.01)
    monkeypatch.setattr(concealed_record, "SETTLE", 0.01)
    monkeypatch.setattr(concealed_record, "path_of", lambda *_: swing(2, 0.1))


@pytest.mark.parametrize("name", ["uneven_encoder", "swinging_tool", "spinning_tool", "dragging_brake"])
def test_what_has_no_name_is_in_a_recording_from_the_strength_of_zero_on(name, at_once):
    robot = sticking(small_arm(lean=1))
    for strength in (0.0, 5.0):
        concealed = OUTSIDE[name](robot, 1, strength, np.random.default_rng(4))
        there, gone = (
            record(one, PLANS["identify_a"], 5).current * robot.arm.gain
            for one in (concealed.robot, concealed.sound)
        )
        seen = np.max(rms(there - gone) / robot.recorder.floor)
        assert seen > 0.5 if strength else seen == 0.0


def test_a_spindle_is_turned_about_by_a_moment_that_takes_no_power():
    robot = sound("ur10like")
    body, n = robot.machine.body, 6
    model = pin.buildModelFromXML(urdf(replace(robot, belief=robot.belief._replace(body=body))))
    data, turned = model.createData(), np.empty((n, 3, 3))
    position, velocity = np.random.default_rng(2).normal(size=(2, n))
    momentum = np.array([0.3, -0.2, 0.5])
    turn(body.rotation, position, turned)
    torque = gyration(momentum, turned, velocity)
    jacobian = pin.computeJointJacobian(model, data, position, n)[3:]
    np.testing.assert_allclose(torque, jacobian.T @ np.cross(jacobian @ velocity, momentum), atol=1e-12)
    assert velocity @ torque == pytest.approx(0.0, abs=1e-12)


def test_a_tool_on_rubber_weighs_at_rest_what_it_would_on_a_flange():
    robot = sticking(small_arm())
    tool = OUTSIDE["swinging_tool"](robot, 1, 5.0, np.random.default_rng(4))
    held = [at_rest(one.machine, np.full(2, 0.4), np.full(2, 35.0)).load for one in (tool.robot, tool.sound)]
    np.testing.assert_allclose(*held, rtol=1e-9)
    assert np.max(np.abs(held[0])) > 0.0


def test_a_drive_goes_where_an_uneven_encoder_says(at_once):
    robot = sticking(small_arm())
    wavy = OUTSIDE["uneven_encoder"](robot, 1, 5.0, np.random.default_rng(4)).robot.machine
    path = swing(2, 0.1)
    log = run(wavy, path, np.zeros((220, 2)), np.full(2, 35.0))
    error = [misread(wavy, 1, angle) for angle in log.link[:, 1]]
    np.testing.assert_allclose(log.link[:, 1] - log.position[:, 1], error, atol=1e-12)
    assert np.ptp(error) > wavy.ring[1, 0] > 0.0
    assert log.position[0, 1] == pytest.approx(path[0, 0, 1], abs=1e-4)


def test_a_brake_that_opens_slowly_drags_against_the_motion_and_is_open_then():
    robot = sticking(small_arm())
    slow = OUTSIDE["dragging_brake"](robot, 1, 2.0, np.random.default_rng(4))
    torque, opening = slow.robot.recorder.drag[1]
    velocity = np.tile([0.5, -0.5], (round(12.0 / STEP), 1))
    drag = drags(slow.robot, velocity, len(velocity) + 100)
    assert not np.any(drag[:, 0])
    assert drag[100, 1] == pytest.approx(-torque)
    assert not np.any(drag[100 + round(slow.span[1] / STEP) :])
    assert np.sum(drag[100:, 1]) * STEP == pytest.approx(-torque * (0.5 * opening + 0.65), rel=1e-3)


def test_a_case_is_read_as_a_user_would_and_tells_nothing(tmp_path):
    arm = ARMS["kr270"]()
    robot = honest(arm, np.random.default_rng(5))
    time = np.arange(100) / RATE
    rest = np.tile(arm.home, (100, 1))
    runs = [
        Run(
            PLANS[name],
            time,
            rest,
            0.1 * rest,
            30.0 + rest,
            0.0 * rest,
            arm.tool if name == "payload" else None,
        )
        for name in ("identify_b", "payload")
    ]
    write_case(tmp_path / "c007", robot, runs)
    first, second = import_source(tmp_path / "c007")
    assert [first.settings["role"], second.settings["role"]] == ["identify", "payload"]
    assert dict(second.payload.known)["M"] == arm.tool.mass
    np.testing.assert_allclose(first.signals["position"].values, rest, atol=1e-7)
    np.testing.assert_allclose(first.model.robot.drive_gain, robot.belief.gain, rtol=1e-5)
    known = first.model.robot.kinematics
    np.testing.assert_allclose([body.mass for body in known.inertias[1:]], robot.belief.body.mass)
    text = (tmp_path / "c007" / "case.toml").read_text()
    assert not [
        name for name in {*VOCABULARY, *OUTSIDE} - {"rotor_inertia", "payload", "drive_gain"} if name in text
    ]


def test_the_whole_set_has_every_effect_under_names_that_tell_nothing():
    cases = concealed_set(1)
    for tier in ("edge", "middle", "clear"):
        assert {case.effects[0] for case in cases if (case.kind, case.tier) == ("single", tier)} == set(
            VOCABULARY
        )
    assert sum(case.kind == "none" for case in cases) == 20
    assert all(case.name == f"c{place:03d}" for place, case in enumerate(cases, start=1))
    assert len({case.seed for case in cases}) == len(cases)
    assert draw("a", "single", ("payload",), "edge", 3) == draw("a", "single", ("payload",), "edge", 3)


def told(kind: str, *effects: tuple[str, set[int]], evidence: float = 1000.0) -> Truth:
    """A truth of two joints."""
    guesses = tuple(Guess(effect, frozenset(joints)) for effect, joints in effects)
    count = len(guesses)
    noise = np.array([1.0, 2.0])
    return Truth(
        "c", kind, "small", guesses, (3.0,) * count, (evidence,) * count, (), noise, 0.5 * noise, 25.0
    )


def said(*findings: tuple[str, list[int]], unexplained: bool = False, others: list | None = None):
    """An answer of two joints, a tenth above the noise floor behind 25 Hz."""
    found = [
        {"effect": effect, "joints": joints, "confidence": 0.9, "alternatives": others or []}
        for effect, joints in findings
    ]
    return read_answer({
        "findings": found, "unexplained": unexplained, "torque_rms_after": [0.55, 1.1],
        "torque_rms_filter_hz": 25.0, "seconds": 2.0,
    })  # fmt: skip


def test_right_answers_have_full_marks():
    cases = [
        Pair(told("single", ("stribeck_friction", {2})), said(("stribeck_friction", [2]))),
        Pair(told("single", ("time_delay", set())), said(("time_delay", [1, 2]))),
        Pair(told("double", ("payload", set()), ("backlash", {1})), said(("backlash", [1]), ("payload", []))),
        Pair(told("none"), said()),
        Pair(told("outside", ("hose_spring", set())), said(unexplained=True)),
    ]
    found = figures(cases)
    ones = ("top1", "joint", "with_alternatives", "double_recall", "double_precision", "outside_unexplained")
    assert [found[name] for name in ones] == [1.0] * 6
    assert [found[name] for name in ("false_alarms", "outside_misnamed", "wrong_name")] == [0, 0, 0]
    assert found["residual_over_noise"] == pytest.approx(1.1)


def test_wrong_answers_have_none():
    truth = told("single", ("stribeck_friction", {2}))
    wrong = figures([Pair(truth, said(("stribeck_friction", [1])))])
    assert (wrong["top1"], wrong["joint"], wrong["wrong_name"]) == (0.0, 0.0, 1.0)
    other = said(("hysteresis", [2]), others=["stribeck_friction"])
    near = figures([Pair(truth, other)])
    assert (near["top1"], near["joint"], near["with_alternatives"]) == (0.0, 1.0, 1.0)
    elsewhere = said(("hysteresis", [1]), others=[{"effect": "stribeck_friction", "joints": [2]}])
    assert figures([Pair(truth, elsewhere)])["with_alternatives"] == 1.0
    three = said(("backlash", [1]), ("payload", []), ("hysteresis", [1]))
    half = figures([Pair(told("double", ("payload", set()), ("backlash", {1})), three)])
    assert (half["double_recall"], half["double_precision"]) == (1.0, pytest.approx(2 / 3))
    assert figures([Pair(told("none"), said(unexplained=True))])["false_alarms"] == 1
    assert (
        figures([Pair(told("outside", ("hose_spring", set())), said(("payload", [])))])["outside_misnamed"]
        == 1.0
    )


def test_what_no_oracle_sees_is_not_asked():
    hidden = Pair(told("single", ("payload", set()), evidence=10.0), said())
    seen = Pair(told("single", ("payload", set())), said(("payload", [])))
    found = figures([hidden, seen])
    assert (found["top1"], found["top1_all_strengths"]) == (1.0, 0.5)


def test_the_strength_found_half_of_the_time():
    strengths = np.geomspace(0.1, 10.0, 41)
    middle, low, high = half_way([(value, value > 0.8) for value in strengths])
    assert middle == pytest.approx(0.8, rel=0.1)
    assert low < 0.8 < high


def test_samples_are_taken_every_fourth_step():
    assert pytest.approx(1.0) == STEP * EVERY * RATE


def test_an_arm_that_falls_is_no_recording():
    robot = honest(ARMS["iiwalike"](), np.random.default_rng(0))
    limits = robot.arm.limits
    for share, standing in ((0.9, True), (1.5, False)):
        path = np.stack([share * limits.lower, share * limits.upper])
        assert stands(robot, SimpleNamespace(position=path)) == standing


def test_simulation_counts_on_the_joints_concerned():
    truth = told("single", ("viscous_friction", {2}))
    count = len(truth.noise)
    answer = replace(
        said(("viscous_friction", [2])),
        simulated_before=np.full(count, 4.0),
        simulated_after=np.where(np.arange(count) == 1, 1.0, 9.0),
    )
    assert simulated_share(Pair(truth, answer)) == pytest.approx(0.25)
    found = figures([Pair(truth, answer)])
    assert (found["simulated"], found["simulated_better"]) == (1, 1.0)
    [[effect, half, low, high, count]] = sensitivity([Pair(truth, answer)])
    assert (effect, count) == ("viscous_friction", 1)
    assert low < half < 3.0 < high  # it was found at three times the noise
