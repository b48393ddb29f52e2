"""Answers of a gap, for findings or for what the robot file states, judged by identified drive gains."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.findings.diagnosis import Diagnosis
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.document.text import blocks_lines
from exidyn.identification.effects import Prior, StribeckFriction, known_parameters
from exidyn.identification.errors import RecordingError
from exidyn.identification.in_mujoco.answer import Answer, DriveGains, attached, drive_gains, file_alone
from exidyn.identification.in_mujoco.distances import Gain, Judge
from exidyn.identification.in_mujoco.gap import gap
from exidyn.identification.in_mujoco.ladder import TOGETHER, Ladder, Step
from exidyn.identification.in_mujoco.replay import POSITION, TORQUE, Run
from exidyn.identification.in_mujoco.trial import Source, Trial
from exidyn.identification.pages.gap_numbers import drive_gains as gain_blocks
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.recording import KnownPayload, Signal
from tests.parts.servo_arms import ARM, described, log, real_arm

mujoco = pytest.importorskip("mujoco", minversion="4.0")

TRUE, STATED = np.array([10.0, 5.0]), np.array([11.0, 4.6])
HEAVY = ARM.replace('mass="2"', 'mass="3"')
"""A file with another mass than the real arm."""
LOAD = '<body pos="0.3 0 0"><inertial mass="1.5" pos="0.05 0 0.03" diaginertia="1e-4 1e-4 1e-4"/></body>'
PAYLOAD = KnownPayload("L", known_parameters(1.5, [0.05, 0.0, 0.03], [1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4]))


def with_gains(gains, tolerance=0.1):
    model = described()
    return replace(
        model,
        robot=replace(model.robot, drive_gain=np.array(gains), drive_gain_tolerance=np.array(tolerance)),
    )


def currents(text, seed, name, payload=None):
    """A run of an arm with currents in place of torques, and the stated gains."""
    run = log(text, seed, name)
    torque = run.signals["torque"]
    signals = {key: signal for key, signal in run.signals.items() if key != "torque"}
    signals["current"] = Signal(torque.time, torque.values / TRUE)
    return replace(run, model=with_gains(STATED), signals=signals, payload=payload)


def moved(phase):
    """A motion of the arm, and its currents with 1 % of noise."""
    time, rate = np.arange(0.0, 4.0, 0.004), np.array([2.0, 3.1])
    angle = rate * time[:, None] + phase
    position, velocity, acceleration = 0.6 * np.array(
        [np.sin(angle), rate * np.cos(angle), -(rate**2) * np.sin(angle)]
    )
    model = mujoco.MjModel.from_xml_string(ARM)
    data, torque = mujoco.MjData(model), np.empty_like(position)
    for row in range(len(time)):
        data.qpos[:], data.qvel[:], data.qacc[:] = position[row], velocity[row], acceleration[row]
        mujoco.mj_inverse(model, data)
        torque[row] = data.qfrc_inverse
    torque *= 1.0 + 0.01 * np.random.default_rng(0).normal(size=torque.shape)
    return Run("run", time, position, velocity, torque / TRUE, True, None, np.zeros(2))


def climbed(file, text, gains):
    """A ladder that has kept a text and drive gains, the trial of the fitted run, and the first distances."""
    judging, training = (
        Trial(Source(file.encode(), ".", "arm.xml"), with_gains(STATED), (moved(phase),), TORQUE)
        for phase in (1.0, 0.0)
    )
    diagnosis = Diagnosis(
        name="two", joints=("shoulder", "elbow"), torque_units=("N m", "N m"), findings=(), runs=("run",),
        noise=np.zeros(2),
    )  # fmt: skip
    ladder = Ladder(judging, (), Filtering(), diagnosis, (), Judge())
    ladder.best = Step(None, with_gains(gains, 0.01), text.encode(), (), ())
    start = judging.distances(file.encode())
    ladder.begin(judging, start)
    return ladder, training, start


def test_a_file_stays_as_it_is_if_only_the_stated_gains_are_wrong():
    ladder, training, start = climbed(ARM, ARM, TRUE)
    [stage] = ladder.stages
    assert (stage.name, stage.gain, stage.reason) == ("drive gains", Gain.BETTER, "")
    file = file_alone(ladder, training)
    assert (file.text, file.changes) == (ARM.encode(), ())
    assert file.distances.tool[1] < 0.1 * start.tool[1]
    np.testing.assert_array_equal(file.arm.robot.drive_gain, TRUE)


def test_a_version_of_the_file_is_judged_by_the_identified_gains():
    ladder, training, start = climbed(HEAVY, ARM, TRUE)
    file = file_alone(ladder, training)
    assert b'mass="2"' in file.text
    assert file.distances.tool[1] < 0.1 * start.tool[1]
    # The other answer, of the same numbers, is no nearer, so there is none.
    ladder.last = ladder.with_gains(ladder.trial).distances(ARM.encode())
    assert attached(ladder, file) is file


def test_gains_that_need_other_masses_do_not_move_the_reference():
    """Masses and gains of the file are too high by the same factor, so its simulation is right."""
    heavier = re.sub(
        r'(mass|diaginertia|damping|armature)="([^"]*)"',
        lambda match: f'{match[1]}="{" ".join(str(1.1 * float(number)) for number in match[2].split())}"',
        ARM,
    )
    ladder, _, start = climbed(heavier, ARM, STATED / 1.1)
    assert [(stage.gain, stage.reason) for stage in ladder.stages] == [(Gain.WORSE, TOGETHER)]
    assert ladder.last is start


def test_commanded_positions_need_no_gains_to_be_simulated():
    ladder, _, start = climbed(ARM, ARM, TRUE)
    ladder.stages.clear()
    ladder.begin(replace(ladder.trial, commands=POSITION, model=with_gains(STATED)), start)
    assert not ladder.stages


def test_gains_are_those_of_what_is_kept_with_their_intervals():
    ladder, training, _ = climbed(ARM, ARM, TRUE)
    gains = drive_gains(ladder, training)
    np.testing.assert_array_equal(gains.stated, STATED)
    np.testing.assert_array_equal(gains.identified, TRUE)
    np.testing.assert_allclose(gains.half, 1.96 * 0.01 * TRUE)
    ladder.best = None
    assert drive_gains(ladder, training).identified is None  # no fit, so the gains stay as stated
    torque = replace(training, runs=[run._replace(current=False) for run in training.runs])
    assert drive_gains(ladder, torque) is None
    text = "\n".join(blocks_lines(gain_blocks(page_of(TRUE))))
    assert "shoulder          11.00               10.00    0.10" in text
    assert "Only the original file" in text
    assert "Only the original file" not in "\n".join(blocks_lines(gain_blocks(page_of(TRUE, POSITION))))
    text = "\n".join(blocks_lines(gain_blocks(page_of(None))))
    assert "identified" not in text
    assert "--payload RUN" in text
    assert gain_blocks(SimpleNamespace(drive_gains=None)) == []


@pytest.mark.parametrize(("loaded", "words"), [("identify", "fitted"), (HELD_OUT, "held-out")])
def test_a_simulation_needs_runs_without_payload(loaded, words):
    runs = [
        (role, currents(ARM, 0, role, PAYLOAD if role == loaded else None)) for role in ("identify", HELD_OUT)
    ]
    with pytest.raises(RecordingError, match=f"every {words} run carries a payload"):
        gap(Source(ARM.encode(), ".", "arm.xml"), with_gains(STATED), runs)


def page_of(identified, commands=TORQUE, changes=()):
    gains = DriveGains(STATED, identified, None if identified is None else 0.01 * TRUE)
    diagnosis, file = SimpleNamespace(joints=("shoulder", "elbow")), SimpleNamespace(changes=changes)
    return SimpleNamespace(drive_gains=gains, commands=commands, diagnosis=diagnosis, file=file)


@pytest.mark.long
def test_a_run_with_a_payload_scales_the_gains_of_servos_too():
    real = real_arm()
    heavy = real.replace('<site name="flange"', f'{LOAD}<site name="flange"')
    runs = [
        ("identify", currents(real, 0, "one")),
        ("payload", currents(heavy, 2, "loaded", PAYLOAD)),
        (HELD_OUT, currents(real, 1, "other")),
    ]
    result = gap(Source(ARM.encode(), ".", "arm.xml"), with_gains(STATED), runs)
    np.testing.assert_allclose(result.drive_gains.identified, TRUE, rtol=2e-3)
    stiffness = [change.new for change in result.servos if change.quantity == "kp"]
    np.testing.assert_allclose(stiffness, (600.0, 300.0), rtol=0.01)
    assert result.file.distances.tool[-1] < 0.01 * result.original.tool[-1]


def with_stribeck():
    """An arm whose robot file states what MJCF cannot hold."""
    model = described()
    effects = (*model.effects, StribeckFriction(joints=("elbow",)))
    return replace(model, effects=effects, stated=dict(model.stated) | {"Fs2": Prior(1.0)})


@pytest.mark.parametrize(
    ("arm", "findings", "gain", "attaches"),
    [
        (described, [], Gain.BETTER, False),  # dry friction by another law
        (described, ["a finding"], Gain.SAME, True),
        (described, ["a finding"], Gain.WORSE, False),
        (with_stribeck, [], Gain.BETTER, True),
        (with_stribeck, [], Gain.SAME, False),
    ],
)
def test_effects_are_attached_for_findings_or_for_what_the_robot_file_states(arm, findings, gain, attaches):
    file = Answer(b"the file", None, (), described())
    ladder = SimpleNamespace(
        judge=SimpleNamespace(compared=lambda first, second: gain),
        best=Step("a fit", arm(), b"a step", (), ()), last=None, findings=findings,
    )  # fmt: skip
    answer = attached(ladder, file)
    assert answer.attaches == attaches
    assert answer.text == (b"a step" if attaches else b"the file")
