"""Cases contain what their owner knows and nothing else."""

from types import SimpleNamespace

import numpy as np
import pytest
from parts.concealed import answer
from parts.concealed.answerers import answerer
from parts.concealed.case import concealed_set, draw, stands
from parts.concealed.case_folder import read_case
from parts.concealed.effects.outside import OUTSIDE
from parts.concealed.effects.vocabulary import VOCABULARY
from parts.concealed.plant.closed_loop import RATE
from parts.concealed.recordings.record import COLOURED, DISTURBING, PLANS, WHITE, Run, coloured
from parts.concealed.recordings.write import write_case
from parts.concealed.robots.arms import ARMS
from parts.concealed.robots.robot import honest

from exidyn.identification import diagnosis

pytestmark = pytest.mark.slow


def test_noise_has_the_size_that_truth_states():
    assert WHITE**2 + COLOURED**2 + DISTURBING**2 == pytest.approx(1.0, abs=0.01)
    noise = coloured(0.85, 40000, 2, np.random.default_rng(0))
    assert np.std(noise) == pytest.approx(1.0, abs=0.05)
    assert np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1] == pytest.approx(0.85, abs=0.02)


@pytest.fixture
def written(tmp_path):
    """A robot with nothing wrong, and the folder of its case: an arm at rest with and without a load."""
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
    return robot, tmp_path / "c007"


def test_a_case_is_read_as_a_user_would_and_shows_nothing(written):
    robot, folder = written
    arm = robot.arm
    first, second = read_case(folder)
    assert [first.settings["role"], second.settings["role"]] == ["identify", "payload"]
    assert dict(second.payload.known)["M"] == arm.tool.mass
    rest = np.tile(arm.home, (100, 1))
    np.testing.assert_allclose(first.signals["position"].values, rest, atol=1e-7)
    np.testing.assert_allclose(first.model.robot.drive_gain, robot.prior.gain, rtol=1e-5)
    known = first.model.robot.kinematics
    np.testing.assert_allclose([body.mass for body in known.inertias[1:]], robot.prior.body.mass)
    text = (folder / "case.toml").read_text()
    assert not [
        name for name in {*VOCABULARY, *OUTSIDE} - {"rotor_inertia", "payload", "drive_gain"} if name in text
    ]


def test_bare_answers_are_of_the_same_runs_by_a_prior_without_values(written, monkeypatch):
    given = []
    monkeypatch.setattr(diagnosis, "diagnose", lambda model, runs, **_: given.append((model, runs)))
    monkeypatch.setattr(answer, "answer", lambda _: {"findings": []})
    for who in ("product", "bare"):
        answerer(who, written[1])(written[1])
    (informed, runs), (bare, same) = given
    assert informed.stated
    assert informed.robot.inertias_stated
    assert not bare.stated
    assert not bare.robot.inertias_stated
    assert bare.effects == informed.effects
    assert [run.name for _, run in same] == [run.name for _, run in runs]


def test_the_whole_set_has_every_effect_under_names_that_show_nothing():
    cases = concealed_set(1)
    for tier in ("edge", "middle", "clear"):
        assert {case.effects[0] for case in cases if (case.kind, case.tier) == ("single", tier)} == set(
            VOCABULARY
        )
    assert sum(case.kind == "none" for case in cases) == 20
    assert all(case.name == f"c{place:03d}" for place, case in enumerate(cases, start=1))
    assert len({case.seed for case in cases}) == len(cases)
    assert draw("a", "single", ("payload",), "edge", 3) == draw("a", "single", ("payload",), "edge", 3)


def test_an_arm_that_falls_is_no_recording():
    robot = honest(ARMS["iiwalike"](), np.random.default_rng(0))
    limits = robot.arm.limits
    for share, standing in ((0.9, True), (1.5, False)):
        path = np.stack([share * limits.lower, share * limits.upper])
        assert stands(robot, SimpleNamespace(position=path)) == standing
