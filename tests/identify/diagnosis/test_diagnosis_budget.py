"""Where the misfit goes: shares that add up, and are as large as the effects are."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.diagnose import noise_floor
from exidyn.identification.diagnosis.questions.question import ask
from exidyn.identification.diagnosis.results.baseline import baselines
from exidyn.identification.diagnosis.results.budget import NOISE, OTHER, budget
from exidyn.identification.diagnosis.results.remainder import discrepancies
from exidyn.identification.diagnosis.runs.usable import usable
from exidyn.identification.preparation.prepare import Filtering

from ...parts.small.small_diagnosis import diagnosis, nominal_model
from ...parts.small.small_rows import asked, blocks, predicted, rows
from ...parts.small.small_search import drag_and_spring_search, record

pytestmark = pytest.mark.slow

COUNT, SIZES, WHITE = 3200, (3.0, 1.5), 0.5


def synthetic(held_out):
    """Two effects of known power on the first joint, one on the second too, beside white noise."""
    random = np.random.default_rng(1)
    torque = WHITE * random.normal(size=(COUNT, 2))
    columns = [random.normal(size=(COUNT, 1, 1)), random.normal(size=(COUNT, 2, 1))]
    torque[:, [0]] += SIZES[0] * columns[0][:, :, 0]
    torque += SIZES[1] * columns[1][:, :, 0]
    given = rows(torque, random.normal(size=(COUNT, 2, 1)), np.array([np.inf]))
    pieces = blocks((160,) * 20, held_out)

    def prediction(found):
        more = given
        for one in found:
            more = more.plus(["x"], one.columns.everywhere(2), one.std, one.mean)
        return predicted(more, pieces)

    pairs = [asked(columns[0], (0,)), asked(columns[1], (0, 1), where=())]
    answers = ask(prediction([]), pairs)
    return SimpleNamespace(prediction=prediction, blocks=pieces), answers


def steps(problem, answers):
    """Predictions with none, one, ... and all findings, and that of the last model, with nothing besides."""
    predictions = [problem.prediction(answers[:count]) for count in range(len(answers) + 1)]
    return predictions, predictions[-1]


@pytest.mark.parametrize("held_out", [(), (16, 17, 18, 19)])
def test_shares_of_known_effects_are_their_powers(held_out):
    problem, found = synthetic(held_out)
    one = budget(*steps(problem, found), [], np.full(2, WHITE), list(map(str, held_out)))
    first, second = SIZES[0] ** 2, SIZES[1] ** 2
    total = np.array([first + second, second]) + WHITE**2
    shares = {
        share.finding if share.finding is not None else share.kind: share.percent / 100.0
        for share in one.shares
    }
    np.testing.assert_allclose(one.before_rms**2, total, rtol=0.1)
    np.testing.assert_allclose(one.after_rms, [WHITE, WHITE], rtol=0.05)
    np.testing.assert_allclose(shares[0], [first / total[0], 0.0], atol=0.03)
    np.testing.assert_allclose(shares[1], second / total, atol=0.03)
    np.testing.assert_allclose(shares[NOISE] + shares[OTHER], WHITE**2 / total, atol=0.02)
    assert one.held_out == tuple(map(str, held_out))
    np.testing.assert_allclose(sum(share.percent for share in one.shares), [100.0, 100.0])
    assert all(np.all(share.percent >= 0.0) for share in one.shares)


def test_a_finding_that_costs_a_joint_something_has_no_share_of_it():
    problem, found = synthetic(())
    noise = np.random.default_rng(5).normal(size=(COUNT, 2, 1))
    [wrong] = ask(problem.prediction([]), [asked(noise, (0, 1), where=(), effect="nothing")])
    one = budget(*steps(problem, [found[1], wrong]), [], np.full(2, WHITE), ())
    assert all(np.all(share.percent >= 0.0) for share in one.shares)
    np.testing.assert_allclose(sum(share.percent for share in one.shares), [100.0, 100.0])
    assert np.all(one.shares[1].percent < 1.0)


def test_the_budget_of_an_arm_adds_up_with_what_is_left():
    found = drag_and_spring_search()
    for kept in (found.selected, found.selected[:1], ()):
        prediction = found.problem.prediction([one.answer for one in kept])
        left = discrepancies(found.problem, prediction)
        part = replace(found, selected=kept, prediction=prediction)
        one = budget(baselines(part), prediction, left, noise_floor(found.problem.runs)[0], ["held out"])
        np.testing.assert_allclose(sum(share.percent for share in one.shares), [100.0, 100.0])
        assert all(np.all(share.percent >= 0.0) for share in one.shares)
        if not kept:
            kinds = {share.kind: share.percent / 100.0 for share in one.shares}
            assert kinds[OTHER].max() < 0.2


def test_a_diagnosis_shows_where_the_misfit_goes():
    budget = diagnosis().budget
    [spring] = [share for share in budget.shares if share.finding == 0]
    assert spring.percent[1] > 95.0
    assert spring.percent[0] < 5.0
    assert budget.held_out


def test_noise_measured_at_rest_in_one_run_holds_for_all():
    """What is above the band of the motion is less than coloured noise within it."""
    run = usable(nominal_model(), record(), Filtering())[0][0]
    rest = replace(run, prepared=replace(run.prepared, noise=2.0 * run.prepared.noise, noise_source="rest"))
    above = replace(run, prepared=replace(run.prepared, noise_source="high frequencies"))
    floor, rested = noise_floor([above, rest, above])
    assert rested
    np.testing.assert_allclose(floor, 2.0 * run.prepared.noise * np.abs(run.prepared.gain))
    mounted_the_other_way = replace(rest, prepared=replace(rest.prepared, gain=-rest.prepared.gain))
    np.testing.assert_allclose(noise_floor([mounted_the_other_way])[0], floor)
    assert not noise_floor([above])[1]
