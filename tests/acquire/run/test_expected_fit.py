"""What a motion would determine, from a simulated arm: its values, its intervals, and what stays open."""

import numpy as np
import pytest

import exidyn as ex
from exidyn.acquire.command_line import main
from exidyn.acquire.run.expected_fit import expected_fit
from exidyn.identification.effects import known_parameters
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import as_built
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.limits.leads import with_leads
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import write_plan
from exidyn.trajectories.random_motion import random_fourier

pytestmark = [pytest.mark.numerical, pytest.mark.slow]

PERIOD = 6.0


def plan_of(model, share=1.0, seed=0):
    """A plan of two random periods; `share` of the amplitude of a motion within the limits."""
    motion = random_fourier(model.robot.limits, 4 * PERIOD, period=PERIOD, harmonics=3, seed=seed)
    core = Fourier(PERIOD, motion.centre, share * motion.sine, share * motion.cosine, 2)
    return Plan.of(with_leads(core, model.robot.limits, 0.002), model, tick=0.002)


@pytest.fixture(scope="module")
def model():
    return read_model("cobot")


@pytest.fixture(scope="module")
def expected(model):
    """Of the large motion without payload, the same for every test: all seeds are fixed."""
    return expected_fit([plan_of(model)], model)


def test_estimates_are_those_of_the_arm_as_built_and_intervals_hold(model, expected):
    built = as_built(model)
    values = dict(zip(built.names, built.nominal_values, strict=True))
    by_name = {parameter.name: parameter for parameter in expected.parameters}
    for name in ("Fv1", "Fc2", "Fc6"):
        assert by_name[name].true == pytest.approx(values[name])
        assert by_name[name].determined
    assert np.mean([parameter.holds for parameter in expected.parameters]) > 0.8
    assert f"of {len(expected.parameters)} parameters" in expected.sentences[0]


def test_a_small_motion_determines_less_and_says_so(model, expected):
    small = expected_fit([plan_of(model, share=0.1)], model)
    assert len(small.open) > len(expected.open)
    assert small.open == sorted(small.open, key=lambda p: p.std / abs(p.true))
    assert small.sentences[-1].startswith(f"Open: {small.open[0].name} (")


def test_a_payload_determines_the_drive_gains(model, expected):
    body = known_parameters(5.0, (0.1, 0.05, 0.1))
    with_body = expected_fit([plan_of(model)], model, [body])
    gains = [p for p in with_body.parameters if p.name.startswith("gain of ")]
    assert len(gains) == model.robot.dof
    assert [gain.true for gain in gains] == pytest.approx(as_built(model).robot.drive_gain)
    assert sum(gain.determined for gain in gains) >= 4
    assert not [p for p in expected.parameters if p.name.startswith("gain of ")]


def test_commands_print_it_before_the_arm_moves(model, tmp_path, capsys):
    write_plan(plan_of(model), tmp_path / "plan.toml")
    run = tmp_path / "run.mcap"
    arguments = ["record", str(tmp_path / "plan.toml"), "--robot", "cobot", "--check", "--no-collision"]
    assert main([*arguments, "--output", str(run)]) == 0
    text = " ".join(capsys.readouterr().err.split())
    assert "On a simulated arm, whose values are off by up to their tolerances," in text
    assert text.index("On a simulated arm") < text.index("written:")
    assert ex.expected_fit("cobot", tmp_path / "plan.toml").sentences[0] in text
