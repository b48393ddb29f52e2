"""Wrong columns, units, signs and robots are named before anything is fitted, and nothing is refused."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.rigid_regressor import rigid_regressor
from exidyn.identification.effects import Payload
from exidyn.identification.effects.payload import known_parameters
from exidyn.identification.effects.rigid_body import inertial_parameters, with_bodies
from exidyn.identification.effects.spring_balancer import SpringBalancer
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.verdict import verdict
from exidyn.identification.plausible.change import with_gravity
from exidyn.identification.plausible.gate import doubts, suspect
from exidyn.identification.plausible.samples import sampled_run
from exidyn.identification.plausible.shares import Columns
from exidyn.identification.plausible.suspicion import AT_TIMES, NONE_OF_THESE, OTHER_MASSES
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.runs.logs import cobot_log, kr270_log, short_log

pytestmark = pytest.mark.numerical

LOG = short_log()
ARM = LOG.model.robot


def recording(position=LOG.position, current=LOG.current, model=LOG.model):
    signals = {"position": Signal(LOG.time, position), "current": Signal(LOG.time, current)}
    return Recording("log", model, signals)


def exchanged(values, a, b):
    columns = np.arange(values.shape[1])
    columns[[a, b]] = b, a
    return values[:, columns]


def scaled(values, joint, factor):
    return values * np.where(np.arange(values.shape[1]) == joint, factor, 1.0)


def test_right_recordings_and_noise_pass():
    assert suspect([recording()], LOG.model) is None
    assert doubts([recording(), recording()], LOG.model) == []
    noise = np.random.default_rng(5).normal(size=LOG.current.shape)
    suspicion = suspect([recording(current=noise)], LOG.model)
    assert suspicion is None or suspicion.name == NONE_OF_THESE
    # A hose on the last joint: as large as the rest of the effort, and of the joint's position.
    hose = 2.0 * LOG.torque.std(axis=0)[3] * np.sin(2.0 * LOG.position[:, 3])
    torque = LOG.torque + np.where(np.arange(ARM.dof) == 3, hose[:, None], 0.0)
    assert suspect([recording(current=torque / ARM.drive_gain)], LOG.model) is None


MISTAKES = {
    "all columns of joint2 and joint3": (exchanged(LOG.position, 1, 2), exchanged(LOG.current, 1, 2)),
    "reverse order": (LOG.position[:, ::-1], LOG.current[:, ::-1]),
    "all efforts have the opposite sign": (LOG.position, -LOG.current),
    "position of joint3 has the opposite sign": (scaled(LOG.position, 2, -1.0), LOG.current),
    "position of joint3 is in degrees": (scaled(LOG.position, 2, 180 / np.pi), LOG.current),
    "efforts are in thousandths": (LOG.position, 1000.0 * LOG.current),
}


@pytest.mark.parametrize("words", MISTAKES)
def test_mistake_is_named(words):
    suspicion = suspect([recording(*MISTAKES[words])], LOG.model)
    assert suspicion is not None
    assert words in suspicion.what
    assert suspicion.probability is not None
    assert suspicion.probability > 0.9


def test_an_arm_described_upside_down_is_no_arm_of_wrong_signs():
    suspicion = suspect([recording()], with_gravity(LOG.model, np.array([0.0, 0.0, 9.81])))
    assert suspicion is not None
    assert suspicion.what.startswith("gravity points along 0.00, 0.00, -1.00 of the base, opposite")


@pytest.mark.parametrize("stated", [True, False])
def test_a_balancer_does_not_turn_gravity_round(stated):
    """Joint 2 has a torque against its weight: described right, it was called upside down.

    Where the balancer is not stated, a spring may hold the arm either way: then nothing is said.
    """
    log = kr270_log()
    model = log.model if stated else without_balancer(log.model)
    current = {"current": Signal(log.time, 1.1 * log.current), "position": Signal(log.time, log.position)}
    run = Recording("log", model, current)
    assert suspect([run], model) is None
    suspicion = suspect([run], with_gravity(model, np.array([0.0, 0.0, 9.81])))
    assert suspicion is not None or not stated
    assert suspicion is None or suspicion.name in ("upside_down", NONE_OF_THESE)


def without_balancer(model):
    kept = tuple(effect for effect in model.effects if not isinstance(effect, SpringBalancer))
    names = set(replace(model, effects=kept, stated={}).names)
    return replace(model, effects=kept, stated={k: v for k, v in model.stated.items() if k in names})


def test_joints_that_hold_their_place_are_not_accused():
    rng = np.random.default_rng(7)
    held = LOG.position.mean(axis=0) + 1e-5 * rng.normal(size=LOG.position.shape)
    position = np.where(np.arange(ARM.dof) == 1, LOG.position, held)
    velocity = np.where(np.arange(ARM.dof) == 1, LOG.velocity, 0.0)
    motion = LOG.model.loaded(Motion.of(LOG.time, position, velocity, 0.0 * velocity))
    torque = LOG.model.torque(motion, LOG.model.nominal_values)
    torque += 0.02 * LOG.torque.std(axis=0) * rng.normal(size=torque.shape)
    assert suspect([recording(position, torque / ARM.drive_gain)], LOG.model) is None


@pytest.mark.long
def test_another_robot_is_not_explained():
    other, log = read_model("kr270"), cobot_log()
    suspicion = suspect([recording(log.position, log.current, other)], other)
    assert suspicion is not None
    assert suspicion.name in (NONE_OF_THESE, OTHER_MASSES)


def test_mistakes_that_no_list_has_are_composed():
    """A joint that counts the other way, an elbow against the ground, and both at once."""
    turned = scaled(LOG.position, 2, -1.0), scaled(LOG.current, 2, -1.0)
    suspicion = suspect([recording(*turned)], LOG.model)
    assert suspicion is not None
    assert suspicion.what.startswith("joint3 counts the other way")
    ground = LOG.position.copy()
    ground[:, 2] += ground[:, 1]
    suspicion = suspect([recording(ground)], LOG.model)
    assert suspicion is not None
    assert suspicion.what == "the position of joint3 is the sum of joint3 and joint2"
    both = suspect([recording(scaled(ground, 3, 180 / np.pi))], LOG.model)
    assert both is not None
    assert {"the position of joint4 is in degrees", suspicion.what} == set(both.what.split("; "))


def test_two_clocks_and_a_push_are_told_from_wrong_columns():
    drift = 0.012 * LOG.time
    late = np.stack([np.interp(LOG.time - drift, LOG.time, column) for column in LOG.current.T], axis=1)
    suspicion = suspect([recording(current=late)], LOG.model)
    assert suspicion is not None
    assert suspicion.name == "two_clocks"
    assert "differ by 1.2" in suspicion.what
    pushed = LOG.current.copy()
    rows = (LOG.time > 8.0) & (LOG.time < 9.5)
    pushed[rows] += 0.5 * LOG.current.std(axis=0)
    suspicion = suspect([recording(current=pushed)], LOG.model)
    assert suspicion is not None
    assert suspicion.name == AT_TIMES


def test_mistakes_of_two_signs_of_scales_and_of_weight_are_named():
    turned = suspect([recording(current=scaled(scaled(LOG.current, 1, -1.0), 2, -1.0))], LOG.model)
    assert turned is not None
    assert turned.what == "the effort of joint2 and joint3 has the opposite sign"
    quarter = suspect([recording(position=0.25 * LOG.position)], LOG.model)
    assert quarter is not None
    assert quarter.name == "position_scale"
    assert quarter.joints == ARM.joints
    floating = with_gravity(LOG.model, np.zeros(3))
    motion = floating.loaded(motion_of(LOG.position))
    torque = floating.torque(motion, floating.nominal_values)
    torque += 0.02 * torque.std(axis=0) * np.random.default_rng(2).normal(size=torque.shape)
    suspicion = suspect([recording(current=torque / ARM.drive_gain)], LOG.model)
    assert suspicion is not None
    assert suspicion.name == "no_gravity"


def test_a_mistake_is_a_warning_first_and_last():
    wrong = recording(exchanged(LOG.position, 0, 1))
    told: list[str] = []
    fit = identify([wrong], progress=told.append)
    assert any("joint1 and joint2 are exchanged" in line for line in told[:3])
    assert "joint1 and joint2 are exchanged" in fit.suspicions[0]
    assert "joint1 and joint2 are exchanged" in verdict(fit)[0]
    assert identify([wrong], as_recorded=True).suspicions == ()


def test_what_single_runs_say_is_not_said_of_all():
    odd = replace(recording(exchanged(LOG.position, 0, 1)), name="odd")
    together = doubts([recording(), odd], LOG.model)
    assert all(line.startswith("odd: ") for line in together)


def test_right_bodies_explain_the_shoulder_and_the_elbow_to_twice_their_noise():
    log = sampled_run(recording())
    assert log is not None
    fit = Columns.of(LOG.model, log).fit(log.effort * ARM.drive_gain)
    assert np.all(fit.share(fit.together)[1:3] < 2 * 0.02**2)


def test_columns_that_nothing_tells_apart_change_nothing():
    log = sampled_run(recording())
    assert log is not None
    rigid = rigid_regressor(ARM.kinematics, log.motion)
    fits = [Columns.of(LOG.model, log, more).fit(log.effort * ARM.drive_gain) for more in (None, rigid)]
    np.testing.assert_allclose(fits[1].together, fits[0].together, rtol=0.2)


def motion_of(position):
    velocity = np.gradient(position, LOG.time, axis=0)
    return Motion.of(LOG.time, position, velocity, np.gradient(velocity, LOG.time, axis=0))


HEAVY = known_parameters(20.0, (0.05, 0.1, 0.2))


@pytest.mark.parametrize(
    ("known", "unit", "named"),
    [(HEAVY, 1.0, ""), (HEAVY[-1:], 1.0, ""), ((), 1.0, ""), (HEAVY, 1.0 / 0.113, "lbf in")],
)
def test_a_stated_payload_counts_as_a_part_of_the_masses(known, unit, named):
    """A light arm with more than its own mass on the flange has the efforts of a heavy arm."""
    bodies = 0.3 * np.array([inertial_parameters(body) for body in list(ARM.kinematics.inertias)[1:]])
    light = {name: prior._replace(value=0.3 * prior.value) for name, prior in LOG.model.stated.items()}
    arm = replace(LOG.model, robot=with_bodies(ARM, bodies), stated=light)
    loaded = arm + Payload("L", HEAVY)
    acceleration = np.gradient(LOG.velocity, LOG.time, axis=0)
    motion = loaded.loaded(Motion.of(LOG.time, LOG.position, LOG.velocity, acceleration, payload="L"))
    torque = unit * loaded.torque(motion, loaded.nominal_values)
    signals = {"torque": Signal(LOG.time, torque), "position": Signal(LOG.time, LOG.position)}
    run = Recording("log", arm, signals, KnownPayload("L", known))
    suspicion = suspect([run], arm + Payload("L", known))
    assert named in suspicion.what if named else suspicion is None
