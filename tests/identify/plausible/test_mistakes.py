"""The table of mistakes, and what its hypotheses change."""

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.plausible.evidence import Reading
from exidyn.identification.plausible.gate import suspect
from exidyn.identification.plausible.joint_mistakes import equal_chains
from exidyn.identification.plausible.mistake import LogFacts
from exidyn.identification.plausible.mistakes import TABLE
from exidyn.identification.plausible.position_servos import servo_gain_doubts
from exidyn.identification.plausible.samples import sampled
from exidyn.identification.plausible.search import weigh
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.recordings.servo_error import LAW
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.runs.logs import short_log

pytestmark = pytest.mark.numerical

LOG = short_log()
ROBOT = LOG.model.robot

LEG = """
  <link name="{leg}_hip"><inertial><origin xyz="0 {side} 0"/><mass value="0.7"/>
    <inertia ixx="0.002" iyy="0.003" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="{leg}_thigh"><inertial><origin xyz="0.01 {side} {length}"/><mass value="{mass}"/>
    <inertia ixx="0.006" iyy="0.006" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{leg}_hip" type="revolute"><parent link="trunk"/><child link="{leg}_hip"/>
    <origin xyz="0 {side} 0"/><axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="40" velocity="20"/>
  </joint>
  <joint name="{leg}_thigh" type="revolute"><parent link="{leg}_hip"/><child link="{leg}_thigh"/>
    <origin xyz="0 {side} 0"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="40" velocity="20"/>
  </joint>
"""


def legs(tmp_path):
    """Two legs that are mirrored, one of them heavier."""
    left = LEG.format(leg="left", side=0.1, length=-0.2, mass=1.2)
    right = LEG.format(leg="right", side=-0.1, length=-0.2, mass=1.8)
    path = tmp_path / "legs.urdf"
    path.write_text(f'<robot name="legs"><link name="trunk"/>{left}{right}</robot>')
    return read_model(path)


def leg_log(model):
    rng, time = np.random.default_rng(8), np.arange(1500) / 100.0
    rate = 2 * np.pi * np.arange(1, 6) / 5.0
    size = 0.25 * rng.normal(size=(4, 5)) / np.arange(1, 6)
    position = np.sin(time[:, None] * rate + 1.0) @ size.T + np.array([0.2, 0.5, -0.2, 0.5])
    velocity = np.gradient(position, time, axis=0)
    motion = model.loaded(Motion.of(time, position, velocity, np.gradient(velocity, time, axis=0)))
    torque = model.torque(motion, model.nominal_values) + 0.3 * np.tanh(velocity / 0.02)
    torque += 0.01 * torque.std(axis=0) * rng.normal(size=torque.shape)
    return time, position, torque


def recorded(model, time, position, torque):
    return Recording("legs", model, {"position": Signal(time, position), "torque": Signal(time, torque)})


def test_exchanged_legs_are_named(tmp_path):
    model = legs(tmp_path)
    time, position, torque = leg_log(model)
    assert equal_chains(model.robot) == [[0, 1], [2, 3]]
    assert suspect([recorded(model, time, position, torque)], model) is None
    other = [2, 3, 0, 1]
    suspicion = suspect([recorded(model, time, position[:, other], torque[:, other])], model)
    assert suspicion is not None
    assert suspicion.name == "exchanged_chains"
    assert suspicion.what.endswith("those of left_hip and right_hip; the log has right_hip, left_hip")


def test_kinds_have_names_of_their_own_and_leave_most_logs_right():
    assert len({mistake.name for mistake in TABLE}) == len(TABLE)
    assert sum(mistake.prior for mistake in TABLE) < 0.15


def test_every_case_changes_a_log_into_one_of_the_same_shape():
    log = sampled(LOG.time, LOG.position, LOG.torque).thinned(100)
    reading = Reading(LOG.model, log, True)
    facts = LogFacts(ROBOT, log, np.full(ROBOT.dof, 30.0), True)
    for mistake in TABLE:
        for case in mistake.cases(facts):
            other = reading.changed(case.change).log
            assert case.clause
            assert set(case.joints) <= set(range(ROBOT.dof))
            assert other.motion.position.shape == other.effort.shape == log.effort.shape


def test_no_mistake_is_trusted_where_it_explains_no_better_than_chance():
    rng = np.random.default_rng(1)
    log = sampled(LOG.time, LOG.position, rng.normal(size=LOG.torque.shape)).thinned(100)
    facts = LogFacts(ROBOT, log, np.full(ROBOT.dof, np.nan), True)
    assert weigh(Reading(LOG.model, log, True), facts).named is None


def test_servo_gains_of_a_file_are_held_against_the_log():
    error = LOG.torque / 18.0
    signals = {"position": Signal(LOG.time, LOG.position), "current": Signal(LOG.time, error)}
    run = Recording("servos", LOG.model, signals, settings={LAW: "servo error [rad] x 1"})
    [words] = servo_gain_doubts([run], LOG.model, np.full(ROBOT.dof, 998.0))
    assert words.startswith("kp of the file is 998")
    assert servo_gain_doubts([run], LOG.model, np.full(ROBOT.dof, 18.0)) == []
