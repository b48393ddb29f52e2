"""Beliefs: a search with free bodies, and one with the bodies as described.

A simulation has the masses of the description. Free bodies fit better, but they can absorb a spring or
a payload; bodies as described show it. Masses of a description are often wrong, too. So both are asked.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from ...effects import name_of
from ...model import Model
from ..blocks.prediction import Prediction
from ..candidates import dependence_of, kind_of
from ..findings.beliefs import Beliefs, Departure
from ..questions.block_answer import CERTAIN_ODDS
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from ..runs.rows import GAIN
from .checks import answer_beside
from .problem import Problem
from .ranking import ranked, total_prior
from .search import SearchResult, search, with_shown
from .selected import Selected, answers_of, keys_of, log_prior

FREE = 100.0
"""Relative standard deviation of free inertias [-]: a flat but finite prior."""
ALIKE = 1.02
"""Ratio of two residuals that still counts as noise [-]."""
RESTORED = 0.9
"""Share of the additional squared residual of bodies as described that a finding must explain to be named
beside free bodies [-]: what it leaves is then less than a tenth of what it explains. A squared residual that
is a tenth larger than with free bodies counts as theirs."""
HALF = 0.5
"""Share of the same that the first of these findings must explain [-]: else at least three are needed."""
BODIES = 2
"""Most bodies that may differ from a description that holds. With a probability of 0.05 each, three of seven
have one of 0.004: a description that does not hold at all is likelier."""
SURE = 0.01
"""Probability that any parameter of a correct model leaves its tolerance by chance [-]."""


def search_both(
    model: Model, runs: Sequence[Driven], brief: bool = False
) -> tuple[SearchResult, Beliefs | None]:
    """The result with bodies as described if a few findings restore them, else that with free bodies.

    Beliefs are None if the description has no bodies, or if torques are in amperes, which no mass explains.
    A brief search has one of both: where simulations of held-out runs judge, what bodies absorb is no loss.
    """
    free = Problem.of(with_tolerance(model, None), runs)
    in_amperes = runs[0].prepared.measures == "current" and np.all(model.robot.drive_gain == 1.0)
    if in_amperes or not any(effect.of_links for effect in model.effects):
        return with_shown(search(free)), None
    described_model = with_tolerance(model, model.robot.inertial_tolerance)
    described = free.with_priors(described_model)
    if np.all(_residual(described.without_findings) <= ALIKE * _residual(free.without_findings)):
        result = with_shown(search(described, brief=brief))
        return result, _beliefs(result, described_model)
    freely = search(free, brief=brief)
    if brief:
        return freely, _beliefs(freely, described_model)
    described = freely.problem.with_priors(described_model)
    start = _without_absorbing(described, freely)
    freely.problem.forget()
    if _may_hold(described, start) and (chosen := _chosen(search(described, start, brief=True), freely)):
        result, without = chosen
        result = with_shown(result)
        return result, _beliefs(result, described_model, without)
    result = with_shown(freely)
    return result, _beliefs(result, described_model)


def with_tolerance(model: Model, tolerance: float | None) -> Model:
    """The model with this relative standard deviation of its inertias; None for free ones."""
    stated = tolerance is not None
    robot = replace(
        model.robot, inertial_tolerance=FREE if tolerance is None else tolerance, inertias_stated=stated
    )
    return replace(model, robot=robot)


def _without_absorbing(described: Problem, freely: SearchResult) -> SearchResult:
    """The result without findings that would take the place of what free bodies absorb."""
    prediction = described.prediction(answers_of(freely.selected), freely.prediction)
    changed = _changed(freely.selected, freely.prediction, prediction)
    kept = tuple(finding for finding in freely.selected if finding not in changed)
    return replace(freely, selected=kept)


def _changed(selected: Sequence[Selected], freely: Prediction, described: Prediction) -> list[Selected]:
    """Findings whose torque differs by more than a residual between two predictions that contain them.

    Any curve of a joint can take the place of a spring that free bodies absorb.
    """
    counts = [len(finding.answer.values) for finding in selected]
    difference = described.values[len(described.values) - sum(counts) :]
    difference = difference - freely.values[len(freely.values) - sum(counts) :]
    residual, changed = freely.power(freely.errors, freely.blocks.fitted), []
    for finding, change in zip(selected, np.split(difference, np.cumsum(counts, dtype=int)), strict=False):
        torque = finding.answer.columns.values @ change
        if np.any(np.mean(torque**2, axis=0) > residual[finding.answer.columns.joints]):
            changed.append(finding)
    return changed


def _may_hold(described: Problem, freely: SearchResult) -> bool:
    """Whether one more hypothesis explains half of what bodies as described leave on a joint."""
    prediction = described.prediction(answers_of(freely.selected))
    fitted, power = described.blocks.fitted, prediction.power
    before, free = (power(errors, fitted) for errors in (prediction.errors, freely.prediction.errors))
    more = np.where(before > ALIKE**2 * free, before - free, np.inf)
    answers = ranked(described, prediction, freely.selected, freely.shapes)
    return any(np.any(before - power(answer.errors, fitted) > HALF * more) for answer in answers)


def _chosen(result: SearchResult, freely: SearchResult) -> tuple[SearchResult, Prediction] | None:
    """The result with bodies as described, and the fit of free bodies without what they absorb.

    None if the description does not hold: too many bodies differ from it, no finding restores a joint, or the
    findings together do not restore all joints. Findings that free bodies absorb are marked; one that
    explains a small part of what the description leaves is unproven.
    """
    bodies = [finding for finding in result.selected if is_body(finding.answer.candidate)]
    absorbed = _absorbed(result, freely)
    free = freely.problem.with_load_of(result.problem)
    without = free.prediction([finding.answer for finding in result.selected if finding not in absorbed])
    restoring = [finding for finding in absorbed if _restores(result, finding, without)]
    before, after, freed = (
        _residual(prediction) ** 2 for prediction in (result.without_findings, result.prediction, without)
    )
    holds = (RESTORED * after <= freed) | (before - after >= RESTORED * (before - freed))
    if len(bodies) > BODIES or not restoring or not np.all(holds):
        return None
    selected = tuple(
        finding._replace(conditional=finding in absorbed, proven=finding.proven and finding in restoring)
        if finding in absorbed
        else finding
        for finding in result.selected
    )
    return replace(result, selected=selected), without


def _absorbed(result: SearchResult, freely: SearchResult) -> list[Selected]:
    """Findings that are not credible with free bodies, given all others, or give another torque there."""
    problem, present = freely.problem.with_load_of(result.problem), keys_of(freely.selected)
    selected, total = result.selected, total_prior(problem)
    with_all = problem.prediction(answers_of(selected), freely.prediction)
    absorbed = _changed(selected, with_all, result.prediction)
    for finding in selected:
        if finding.once or finding.answer.candidate.key in present or finding in absorbed:
            continue
        others = answers_of([other for other in selected if other is not finding])
        answer = answer_beside(problem, finding.answer, others, with_all)
        if answer is None or answer.odds + log_prior(answer, total) < CERTAIN_ODDS:
            absorbed.append(finding)
    return absorbed


def _restores(result: SearchResult, finding: Selected, free: Prediction) -> bool:
    """Whether a joint of a finding fits nearly as well as with free bodies, and by far not without it."""
    others = [other for other in result.selected if other is not finding]
    acting = finding.answer.columns.joints
    without, with_it, freely = (
        _residual(prediction)[acting] ** 2
        for prediction in (result.problem.prediction(answers_of(others)), result.prediction, free)
    )
    explained, more = without - with_it, without - freely
    return bool(np.any((without > ALIKE**2 * with_it) & (explained >= RESTORED * more)))


def _residual(prediction: Prediction) -> np.ndarray:
    """Residual of held-out runs, or of left-out blocks without such runs, shape (n,) [N m]."""
    judged = ~prediction.blocks.fitted
    return np.sqrt(prediction.power(prediction.errors, judged if np.any(judged) else None))


def is_body(candidate: Candidate) -> bool:
    """Whether a hypothesis is another link than described, or a payload."""
    return dependence_of(candidate) == "mass" and kind_of(candidate.effect).of_body


def _beliefs(result: SearchResult, described: Model, free: Prediction | None = None) -> Beliefs:
    """Beliefs without the indices of findings, which are sorted later."""
    return Beliefs(
        conditional=(),
        absorbed_by=() if free is None else tuple(departures(described, free)),
        departures=tuple(departures(described, result.prediction)),
        described_rms=_residual(result.prediction),
        free_rms=_residual(free or result.prediction),
    )


def departures(described: Model, prediction: Prediction) -> Iterator[Departure]:
    """For each body, rotor and drive gain, the parameter that leaves its tolerance furthest, if any does.

    The first unknowns of the prediction are the changes of the parameters of the model.
    """
    rows, values = prediction.rows, prediction.values
    units = {parameter.name: parameter.unit for parameter in described.parameters}
    groups = _groups(described)
    stated = [
        (name, prior.value, value, prior.std)
        for name, prior, value in zip(described.names, described.priors, values, strict=False)
    ]
    stated += [
        (name, 0.0, value, std)
        for name, value, std in zip(rows.names, values, rows.std, strict=True)
        if name.startswith(GAIN)
    ]
    counted = [row for row in stated if row[0] in groups and np.isfinite(row[3]) and row[3] > 0.0]
    most = stats.norm.isf(SURE / 2.0 / max(len(counted), 1))
    best: dict[tuple[str, int], Departure] = {}
    for name, nominal, change, std in counted:
        place, deviations = groups[name], abs(change) / std
        if deviations > max(most, best[place].deviations if place in best else 0.0):
            unit = units.get(name, "1")
            best[place] = Departure(
                *place, name, float(deviations), float(nominal), float(nominal + change), unit
            )
    yield from best.values()


def _groups(model: Model) -> dict[str, tuple[str, int]]:
    """Group and joint of each parameter that belongs to a body, a rotor or a drive, by name."""
    groups: dict[str, tuple[str, int]] = {}
    for effect in model.effects:
        kind, joints = kind_of(name_of(effect)), effect.parameter_joints(model.robot)
        rotor = kind.family == "mass" and not kind.of_body
        if group := "link" if effect.of_links else "rotor" if rotor else "":
            pairs = zip(effect.parameters(model.robot), joints, strict=True)
            groups |= {parameter.name: (group, joint) for parameter, joint in pairs if joint is not None}
    return groups | {f"{GAIN}{joint + 1}": ("drive gain", joint) for joint in range(model.robot.dof)}
