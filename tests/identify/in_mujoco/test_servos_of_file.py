"""Servos and numbers of a file from plain MuJoCo as the real arm: what changes, and what does not."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.robot import PositionServo
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.fit.servo_fit import ServoRun, identify_servos
from exidyn.identification.in_mujoco.distances import Judge
from exidyn.identification.in_mujoco.gap import gap
from exidyn.identification.in_mujoco.joint_numbers import (
    DAMPING,
    DRY,
    KP,
    LIMIT,
    JointNumbers,
    changed_law,
    servo_changes,
)
from exidyn.identification.in_mujoco.replay import Run
from exidyn.identification.in_mujoco.servo_stage import servo_stage
from exidyn.identification.in_mujoco.simulated_numbers import simulated_numbers
from exidyn.identification.in_mujoco.trial import Source, Trial
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.robot_files.mjcf_drives import servo_law
from tests.parts.servo_arms import ARM, commands_alone, described, log, real_arm

mujoco = pytest.importorskip("mujoco", minversion="4.0")

SOURCE = Source(ARM.encode(), ".", "arm.xml")


def runs_of(text):
    return [("identify", log(text, 0, "one")), (HELD_OUT, log(text, 1, "other"))]


def file_law():
    return servo_law(mujoco.MjModel.from_xml_string(ARM), ("shoulder", "elbow"))


def test_servos_like_those_of_the_file_change_nothing():
    fit = identify_servos([ServoRun.of(log(ARM, 0, "run"), np.ones(2))])
    assert servo_changes(fit, file_law()) == ()


def test_what_differs_is_listed_joint_by_joint():
    fit = identify_servos([ServoRun.of(log(real_arm(), 0, "run"), np.ones(2))])
    changes = servo_changes(fit, file_law())
    known = [(joint, quantity) for joint in (0, 1) for quantity in ("kp", "kv")]
    assert [(change.joint, change.quantity) for change in changes] == known
    for change in changes:
        true = {"kp": (600.0, 300.0), "kv": (60.0, 30.0)}[change.quantity][change.joint]
        assert abs(change.new - true) < change.half
    law = changed_law(file_law(), changes)
    np.testing.assert_allclose(law.stiffness, (600.0, 300.0), rtol=0.02)


@pytest.mark.parametrize("alone", [False, True])
def test_the_servos_alone_take_most_of_the_gap(alone):
    raw = runs_of(real_arm())
    recordings = [(role, commands_alone(run)) for role, run in raw] if alone else raw
    stage = servo_stage(SOURCE, described(), recordings, raw, Filtering(), Judge())
    assert not stage.reason
    trial = Trial(SOURCE, described(), [Run.of(raw[1][1], Filtering())], "position", stage.held)
    before, after = (trial.distances(text).tool[-1] for text in (SOURCE.text, stage.source.text))
    assert after < 0.6 * before  # the friction that the file lacks remains


def test_a_placeholder_gain_of_a_robot_file_is_no_stated_value():
    """A proposed robot file states a servo gain of 1, and a drive gain that nobody knows."""
    model, texts = described(), []
    stated = PositionServo(np.ones(2), np.full(2, np.inf))
    proposed = replace(model.robot, servo=stated, drive_gain=np.array([100.0, 30.0]))
    for arm in (model, replace(model, robot=proposed)):
        runs = [(role, replace(commands_alone(run), model=arm)) for role, run in runs_of(real_arm())]
        result = gap(SOURCE, arm, runs)
        assert {(change.joint, change.quantity) for change in result.servos} >= {(0, "kp"), (1, "kp")}
        texts.append(result.file.text)
    assert texts[0] == texts[1]


def test_a_simulation_delays_the_commands_of_a_run_by_the_delay_of_the_file():
    """The file of the real arm follows its own log from any start."""
    raw = log(real_arm(), 1, "other")
    trial = Trial(
        Source(real_arm().encode(), ".", "real.xml"), described(), [Run.of(raw, Filtering())], "position"
    )
    assert trial.distances(real_arm().encode()).tool[-1] < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("alone", [False, pytest.param(True, marks=pytest.mark.long)])
def test_both_answers_and_the_file_by_itself_closes_what_it_can_hold(alone):
    recordings = runs_of(real_arm())
    if alone:
        recordings = [(role, commands_alone(run)) for role, run in recordings]
    result = gap(SOURCE, described(), recordings)
    assert result.file.distances.tool[-1] < 0.1 * result.original.tool[-1]
    changed = {(change.where, change.attribute): change.new for change in result.file.changes}
    assert changed[("joint 'shoulder'", "frictionloss")] == pytest.approx(2.0, rel=0.15)
    assert all(attribute != "mass" for _, attribute in changed)
    mujoco.MjModel.from_xml_string(result.file.text.decode())


@pytest.mark.slow
def test_a_file_that_is_right_stays_as_it_is():
    result = gap(SOURCE, described(), runs_of(ARM))
    assert not result.changed
    assert result.file.text == result.attached.text == SOURCE.text


STICKING = {
    'kp="800" kv="40"': 'kp="100" kv="2"',
    'kp="400" kv="20"': 'kp="50" kv="1"',
    'damping="1"': 'damping="1" frictionloss="30"',
    'damping="0.5"': 'damping="0.5" frictionloss="12"',
}
"""What differs in an arm whose dry friction exceeds the torque of its bodies."""


def simulated(text):
    """Numbers by simulation, from commands alone."""
    runs = [Run.of(log(text, seed, "run"), Filtering()) for seed in (0, 4)]
    trials = [Trial(SOURCE, described(), [run], "position") for run in runs]
    numbers = JointNumbers(SOURCE, described().robot)
    return numbers, simulated_numbers(numbers, *trials, SOURCE.text)


@pytest.mark.slow
def test_gains_that_dry_friction_hides_come_from_simulations():
    text = ARM
    for old, new in STICKING.items():
        text = text.replace(old, new)
    _, result = simulated(text)
    np.testing.assert_allclose(result.values[KP], (100.0, 50.0), rtol=0.05)
    np.testing.assert_allclose(result.values[DRY], (30.0, 12.0), rtol=0.05)
    assert np.all(np.abs(result.values[KP] - (100.0, 50.0)) < result.halves[KP])


@pytest.mark.slow
def test_only_the_joint_that_differs_is_changed():
    numbers, result = simulated(ARM.replace('damping="0.5" armature="0.05"', 'damping="3" armature="0.05"'))
    changed = np.argwhere(result.values != numbers.values).tolist()
    assert changed == [[DAMPING, 1]]
    assert result.values[DAMPING, 1] == pytest.approx(20.0 + 3.0, rel=0.02)


@pytest.mark.slow
def test_numbers_of_a_right_file_stay():
    numbers, result = simulated(ARM)
    np.testing.assert_array_equal(result.values, numbers.values)
    assert not numbers.servo_changes(result.values, result.halves)


@pytest.mark.parametrize(("limit", "reached"), [(18.0, True), (25.0, False)])
def test_a_limit_without_measured_torque_comes_from_simulations(limit, reached):
    numbers, result = simulated(ARM.replace('kv="40"', f'kv="40" forcerange="-{limit} {limit}"'))
    changes = numbers.servo_changes(result.values, result.halves)
    assert [(change.joint, change.quantity) for change in changes] == [(0, "forcerange")] * reached
    if reached:
        assert result.values[LIMIT, 0] == pytest.approx(limit, rel=0.01)
