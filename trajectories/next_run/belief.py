"""Belief: what a diagnosis leaves open, and with which probabilities and precisions."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import erfc, expit

from exidyn.identify.diagnosis.blocks.prediction import CERTAIN, factored, solve
from exidyn.identify.diagnosis.questions.block_answer import Answer, prior_std
from exidyn.identify.diagnosis.questions.comparison import LINEAR
from exidyn.identify.diagnosis.results.evidence import places_of
from exidyn.identify.diagnosis.search.search import SearchResult
from exidyn.identify.diagnosis.search.selected import CERTAIN_ODDS, EXCLUDED, Selected, log_prior

from .columns import RunColumns

NUISANCES = ("reversal", "clock")
"""Beginnings of the names of unknowns that are nobody's question."""

NEGLIGIBLE = EXCLUDED / 100.0
"""Probability below which an effect that nothing suggests is not asked about; a hundred of them are still
excluded together."""


class Believed(NamedTuple):
    """One answer to a question.

    Attributes:
        effect: Name in the vocabulary; empty for nothing.
        joints: Where, from 0.
        probability: [-].
        places: Of its coefficients among all columns, (p,).
    """

    effect: str
    joints: tuple[int, ...]
    probability: float
    places: np.ndarray


class Stance(NamedTuple):
    """All columns' coefficients if one answer is true.

    Attributes:
        held: Columns that are there, (s,).
        precision: Of them, shape (s, s).
        values: Of all columns, shape (c,).
        ways: In which the answer's own coefficients may still differ, one standard deviation each, with all
            that follows them, shape (c, p).
    """

    held: np.ndarray
    precision: np.ndarray
    values: np.ndarray
    ways: np.ndarray


class Question(NamedTuple):
    """What may explain one misfit, or whether one effect is there.

    Attributes:
        answers: The most probable first; their probabilities add to one.
        seen: Whether a misfit asks it; else nothing does but that no run so far could show the effect.
        own: Unknowns that belong to the finding in question, not there for other answers, (p,).
    """

    answers: tuple[Believed, ...]
    seen: bool
    own: np.ndarray

    @property
    def probabilities(self) -> np.ndarray:
        """Of the answers, shape (m,)."""
        return np.array([one.probability for one in self.answers])


@dataclass(frozen=True, eq=False)
class Belief:
    """The posterior of a diagnosis: unknowns, then coefficients of all suspects, c columns together.

    Attributes:
        search: Of the diagnosis.
        suspects: What is not in the model and may be there.
        gram: Products of all columns over the runs so far, weighted as the diagnosis did, shape (c, c).
        right: The same with what they explain, shape (c,).
        precision: Of priors, shape (c,); zero where nothing is known.
        mean: Of priors, shape (c,).
        weight: Of a row of each joint of a further run, shape (n,) [1 / (N m)^2].
        reaches: Products of all columns over the runs so far, and over each on offer, in units of the
            resolution, a mean over rows, shape (k, c, c): the mean square torque of any coefficients.
        questions: What is open.
    """

    search: SearchResult
    suspects: tuple[Answer, ...]
    gram: np.ndarray
    right: np.ndarray
    precision: np.ndarray
    mean: np.ndarray
    weight: np.ndarray
    reaches: np.ndarray
    questions: tuple[Question, ...] = ()

    @cached_property
    def reach(self) -> np.ndarray:
        """The same over all of them, shape (c, c)."""
        return np.asarray(self.reaches.mean(axis=0))

    @property
    def unknowns(self) -> int:
        """Number of unknowns that are in the model already."""
        return len(self.search.prediction.rows.names)

    @property
    def places(self) -> list[np.ndarray]:
        """Columns of each suspect."""
        counts = [one.columns.values.shape[2] for one in self.suspects]
        stops = self.unknowns + np.cumsum([0, *counts])
        return [np.arange(a, b) for a, b in zip(stops[:-1], stops[1:], strict=True)]

    def posterior(self, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Precision (s, s) and mean (s,) of some columns (s,), all others being zero."""
        matrix = self.gram[np.ix_(which, which)] + np.diag(self.precision[which])
        right = self.right[which] + self.precision[which] * self.mean[which]
        return matrix, solve(factored(matrix), right)

    def held_by(self, question: Question, answer: Believed) -> np.ndarray:
        """Columns that are there if an answer is true, (s,); its own are the last."""
        rest = np.setdiff1d(np.arange(self.unknowns), np.concatenate([question.own, answer.places]))
        return np.concatenate([rest, answer.places]).astype(int)

    def stance(self, question: Question, answer: Believed) -> Stance:
        """What is believed if an answer is true."""
        held, count = self.held_by(question, answer), len(answer.places)
        matrix, mean = self.posterior(held)
        values, ways = np.zeros(len(self.gram)), np.zeros((len(self.gram), count))
        values[held] = mean
        if count:
            rest, own = slice(0, len(held) - count), slice(len(held) - count, None)
            followed = -solve(factored(matrix[rest, rest]), matrix[rest, own])
            apart = matrix[own, own] + matrix[own, rest] @ followed
            covariance = solve(factored(apart), np.eye(count))
            ways[held] = np.concatenate([followed, np.eye(count)]) @ np.linalg.cholesky(covariance)
        return Stance(held, matrix, values, ways)


def suspects_of(search: SearchResult) -> tuple[Answer, ...]:
    """Alternatives of the findings, then all that was not found, each in its best shape."""
    alternatives = [answer for one in search.selected for answer, _ in one.elsewhere]
    keys = {one.candidate.key for one in alternatives}
    left = [one for one in search.left if one.candidate.key not in keys]
    return (*alternatives, *left)


def belief_of(search: SearchResult, suspects: Sequence[Answer], runs: Sequence[RunColumns]) -> Belief:
    """The belief after a search, and what runs on offer could show."""
    prediction = search.prediction
    joints, fitted = prediction.joints, prediction.weighting.weight[prediction.blocks.number]
    columns = np.concatenate(
        [prediction.rows.columns, *(one.columns.everywhere(joints) for one in suspects)], axis=2
    )
    weight = fitted * prediction.rows.weight
    alternatives = sum(len(one.elsewhere) for one in search.selected)
    std = [prediction.rows.std]
    for place, one in enumerate(suspects):
        if place < alternatives:
            std.append(prior_std(one.candidate, one.columns))
        else:  # no larger in any run than it may be there: the run that shows it best limits it
            std.append(np.min([one.columns.std, *(run.suspects[place].std for run in runs)], axis=0))
    deviation = np.maximum(np.concatenate(std), CERTAIN)
    mean = np.concatenate([prediction.rows.mean, *(one.columns.mean for one in suspects)])
    belief = Belief(
        search,
        tuple(suspects),
        products(columns, weight),
        np.einsum("rnc,rn->c", columns, weight * prediction.rows.difference),
        deviation**-2.0,
        mean,
        prediction.weighting.independent / prediction.weighting.variance,
        _reaches(search, columns, weight > 0.0, runs),
    )
    return replace(belief, questions=(*_asked(belief), *_unseen(belief, alternatives)))


def products(columns: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Products of columns (r, n, c) over rows and joints with a weight (r, n), shape (c, c)."""
    flat = (columns * np.sqrt(weight)[:, :, None]).reshape(-1, columns.shape[2])
    return flat.T @ flat


def all_columns(run: RunColumns, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns of a run, and what it brings of its own: the unknowns of a body that no run has carried so far.

    Returns:
        Columns of named unknowns and all suspects (r, n, c); of the others (r, n, e); their precision (e,).
    """
    place = {name: k for k, name in enumerate(run.rows.names)}
    known = run.rows.columns[:, :, [place[name] for name in names]]
    joints = known.shape[1]
    every = np.concatenate([known, *(one.everywhere(joints) for one in run.suspects)], axis=2)
    more = [k for name, k in place.items() if name not in set(names)]
    return every, run.rows.columns[:, :, more], np.maximum(run.rows.std[more], CERTAIN) ** -2.0


def _reaches(
    search: SearchResult, columns: np.ndarray, counts: np.ndarray, runs: Sequence[RunColumns]
) -> np.ndarray:
    """As in `Belief`: the resolution is a share of the largest usual torque of each joint."""
    names = search.prediction.rows.names
    torque = np.concatenate([run.thinned(run.torque) for run in search.problem.runs])
    parts = [(columns, counts, torque)]
    parts += [(all_columns(run, names)[0], run.rows.weight > 0.0, run.torque) for run in runs]
    usual = np.sqrt(np.max([np.mean(torque**2, axis=0) for _, _, torque in parts], axis=0))
    resolution = LINEAR * np.maximum(usual, 1e-9)
    return np.array([products(own, seen / resolution**2 / max(len(own), 1)) for own, seen, _ in parts])


def _asked(belief: Belief) -> Iterator[Question]:
    """A question for each finding: whether it is that, what else it may be, or nothing."""
    keys = [one.candidate.key for one in belief.suspects]
    for place, one in enumerate(belief.search.selected):
        if one.once:
            continue  # it is in no other run
        own, here = places_of(belief.search, place), one.answer.candidate
        answers = [Believed(here.effect, here.joints, one.certainty, own)]
        for other, probability in one.elsewhere:
            candidate = other.candidate
            where = belief.places[keys.index(candidate.key)]
            answers.append(Believed(candidate.effect, candidate.joints, probability, where))
        yield Question(_complete(answers, one), True, own)


def _complete(answers: list[Believed], one: Selected) -> tuple[Believed, ...]:
    """The answers and that nothing is there; what is excluded has the rest."""
    total = sum(answer.probability for answer in answers)
    nothing = min(float(expit(-one.odds)), max(1.0 - total, 0.0))
    every = [*answers, Believed("", (), nothing, np.zeros(0, int))]
    total = sum(answer.probability for answer in every)
    every = [answer._replace(probability=answer.probability / total) for answer in every]
    return tuple(sorted(every, key=lambda answer: -answer.probability))


def _unseen(belief: Belief, first: int) -> Iterator[Question]:
    """Whether an effect that was not found is there all the same, and large enough to matter."""
    none = np.zeros(0, int)
    for place, one in enumerate(belief.suspects):
        if place < first or one.held_out < -CERTAIN_ODDS:
            continue
        odds = min(one.gain, one.odds, 0.0) + log_prior(one, belief.search.total)
        there = Believed(one.candidate.effect, one.candidate.joints, 1.0, belief.places[place])
        question = Question((there,), False, none)
        probability = float(expit(odds)) * _material(belief, question, there)
        if probability < NEGLIGIBLE:
            continue
        answers = (there._replace(probability=probability), Believed("", (), 1.0 - probability, none))
        yield question._replace(answers=tuple(sorted(answers, key=lambda answer: -answer.probability)))


def _material(belief: Belief, question: Question, answer: Believed) -> float:
    """Probability that an effect, if it is there, gives torque beyond the resolution in some run."""
    stance, places = belief.stance(question, answer), answer.places
    own = np.column_stack([stance.values, stance.ways])[places]
    each = belief.reaches[:, places[:, None], places]
    square = float(np.max(np.sum(own * (each @ own), axis=(1, 2))))
    return float(erfc(1.0 / np.sqrt(2.0 * max(square, 1e-12))))
