"""The balancer's example: its steps in short, and its statements about them, right or wrong."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.commands.example_command import run
from exidyn.acquire.examples import example_balancer
from exidyn.acquire.examples.example_balancer import words
from exidyn.acquire.examples.example_result import Result
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.limits.leads import with_leads
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import write_plan
from exidyn.trajectories.random_motion import random_fourier

pytestmark = [pytest.mark.clocked(patient=True), pytest.mark.long]

TICK, PERIOD = 0.002, 6.0


def write_motion(folder, name, seed):
    """In place of a search: two random periods within the limits."""
    model = read_model(str(folder / "robot.toml"))
    limits = replace(
        model.robot.limits, position_upper=model.robot.limits.position_upper - [0, 0.6, 0, 0, 0, 0]
    )
    one = random_fourier(limits, 4 * PERIOD, period=PERIOD, harmonics=2, seed=seed)
    core = Fourier(PERIOD, one.centre, one.sine, one.cosine, 2)
    write_plan(Plan.of(with_leads(core, model.robot.limits, TICK), model, tick=TICK), folder / f"{name}.toml")


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """All steps but the searches."""
    folder = tmp_path_factory.mktemp("balancer")
    example_balancer.arm().write(folder)
    for seed, name in enumerate(("trajectory", "loaded", "other")):
        write_motion(folder, name, seed)
    run([one for one in example_balancer.steps(folder, 20.0, None) if one.command != "excite"])
    return Result.read(folder)


def test_what_is_concealed_is_named_and_nothing_else(result):
    assert [(one["effect"], one["joints"]) for one in result.findings] == [("spring_balancer", [2])]
    text = words(result)
    assert "named:     spring_balancer of joint 2, probability above 99.9 %: right\n" in text
    assert "NOT" not in text
    assert "WRONG" not in text


def test_its_torque_is_right(result):
    real, found = (spring.torque(result.robot) for spring in (result.concealed, result.estimate))
    # masses are known to a tenth, and of what they weigh at joint 2 the spring's wave is as good a guess
    assert np.max(np.abs(found - real)) < 0.1 * np.max(np.abs(real))


def test_simulation_comes_near_the_recording_and_the_residual_to_noise(result):
    joint = result.joint
    assert result.residuals["simulated after"][joint] < 0.2 * result.residuals["simulated before"][joint]
    assert result.residuals["simulated after"][joint] < 2.0  # over noise
    assert result.residuals["found"][joint] < 2.0 < 0.1 * result.residuals["nominal"][joint]


def test_other_simulators_get_the_spring_or_what_is_missing_is_reported(result):
    assert "spring" in (result.folder / "kr270.xml").read_text()
    assert "<robot" in (result.folder / "kr270.urdf").read_text()
    assert "Kr" in read_model(str(result.folder / "improved.toml")).names


def test_a_wrong_answer_is_called_wrong(result):
    other = result.findings[0] | {"effect": "joint_spring", "joints": [3]}
    missed = words(replace(result, findings=[other]))
    assert "NOT spring_balancer of joint 2. Named instead: joint_spring of joint 3" in " ".join(
        missed.split()
    )
    assert ": right" not in missed
    assert "Named instead: nothing" in words(replace(result, findings=[]))
    both = words(replace(result, findings=[*result.findings, other]))
    assert "WRONG: joint_spring of joint 3" in " ".join(both.split())
    elsewhere = result.findings[0] | {"joints": [3]}
    assert "NOT spring_balancer of joint 2" in words(replace(result, findings=[elsewhere]))


def test_lengths_in_another_scale_are_the_same_spring(result):
    spring = result.concealed
    longer = replace(spring.effect, d21=3 * spring.effect.d21, d22=3 * spring.effect.d22)
    same = spring._replace(effect=longer, stiffness=spring.stiffness / 9, preload=spring.preload / 3)
    np.testing.assert_allclose(same.torque(result.robot), spring.torque(result.robot))
    again = same.as_long_as(spring)
    np.testing.assert_allclose(again[1:], spring[1:])
    np.testing.assert_allclose(spring.in_place_of(same, result.robot)[1:], spring[1:])


def test_the_prior_has_no_balancer_and_is_right_otherwise():
    arm = example_balancer.arm()
    lost = set(arm.truth.names) - set(arm.nominal.names)
    assert lost == {"Kr", "K0"}
    values = dict(zip(arm.truth.names, arm.truth.nominal_values, strict=True))
    assert [values[name] for name in arm.nominal.names] == list(arm.nominal.nominal_values)
