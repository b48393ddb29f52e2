"""Belief: the open questions of a diagnosis, with probabilities and precisions."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...positive_definite import root, solve
from ..blocks.prediction import factored
from ..questions.block_answer import CREDIBLE, Answer
from ..questions.candidate_fit import FORMULA
from ..search.search import SearchResult
from ..search.selected import NAMED


class Believed(NamedTuple):
    """One answer to a question."""

    effect: str  # name in the vocabulary; empty for "no effect"
    joints: tuple[int, ...]  # joints it acts on, from 0
    probability: float  # probability of the answer [-]
    places: np.ndarray  # indices of its coefficients among all columns, shape (p,)


class Question(NamedTuple):
    """Which effect explains a misfit, or whether an effect is there at all."""

    answers: tuple[Believed, ...]  # possible answers, most probable first; their probabilities add to one
    # whether a misfit, or values strained beyond their tolerances, raise the question; otherwise it is open
    # only because no run so far could show the effect
    seen: bool
    # unknowns of the finding in question, absent for other answers, shape (p,); empty for a suspect that was
    # not found
    finding_places: np.ndarray

    @property
    def probabilities(self) -> np.ndarray:
        """Probabilities of the answers, shape (m,)."""
        return np.array([answer.probability for answer in self.answers])

    @property
    def decisive(self) -> np.ndarray:
        """Probability from which on each answer decides the question, shape (m,).

        "No effect" never decides about a finding, which would not be one otherwise. It decides about a
        suspect once it is as probable as an effect must be to be named.
        """
        no_effect = np.inf if self.finding_places.size else NAMED
        return np.array([CREDIBLE if answer.effect else no_effect for answer in self.answers])

    @property
    def settled(self) -> bool:
        """Whether one of the answers decides the question."""
        return bool(np.any(self.probabilities >= self.decisive))


class Stance(NamedTuple):
    """Coefficients of all columns if one answer is true."""

    held: np.ndarray  # indices of the columns that are present, shape (s,)
    precision: np.ndarray  # precision of their priors, shape (s,)
    mean: np.ndarray  # prior mean of the answer's own coefficients, zero for all other columns, shape (c,)
    # expected coefficients of the answer in the first column, and deviations by one standard deviation in the
    # others, for all columns, shape (c, w)
    variations: np.ndarray


@dataclass(frozen=True, eq=False)
class Belief:
    """The posterior of a diagnosis: unknowns, then coefficients of all suspects, c columns together."""

    search: SearchResult  # search of the diagnosis
    suspects: tuple[Answer, ...]  # effects that are not in the model and may be there
    # products of all columns over the runs so far, weighted as in the diagnosis, shape (c, c)
    gram: np.ndarray
    right: np.ndarray  # right-hand side of the normal equations, shape (c,)
    precision: np.ndarray  # precision of the priors, shape (c,); zero without a prior
    mean: np.ndarray  # mean of the priors, shape (c,)
    weight: np.ndarray  # weight of a row of each joint in a further run, shape (n,) [1 / (N m)^2]
    # mean products of all columns over the rows of the runs so far, and of each run on offer, in units of the
    # resolution, shape (k, c, c); they give the mean square torque of coefficients
    reaches: np.ndarray
    questions: tuple[Question, ...] = ()  # open questions

    @cached_property
    def reach(self) -> np.ndarray:
        """Mean of `reaches` over all runs, shape (c, c)."""
        return np.asarray(self.reaches.mean(axis=0))

    @property
    def unknowns(self) -> int:
        """Number of unknowns that the model already contains."""
        return len(self.search.prediction.rows.names)

    @property
    def places(self) -> list[np.ndarray]:
        """Columns of each suspect."""
        counts = [suspect.columns.values.shape[2] for suspect in self.suspects]
        stops = self.unknowns + np.cumsum([0, *counts])
        return [np.arange(a, b) for a, b in zip(stops[:-1], stops[1:], strict=True)]

    def posterior(self, held: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Posterior precision (s, s) and mean (s,) of some columns (s,), all others held at zero."""
        matrix = self.gram[np.ix_(held, held)] + np.diag(self.precision[held])
        right = self.right[held] + self.precision[held] * self.mean[held]
        return matrix, solve(factored(matrix), right)

    def held_by(self, question: Question, answer: Believed) -> np.ndarray:
        """Columns that are present if an answer is true, shape (s,); those of the answer are the last."""
        excluded = np.concatenate([question.finding_places, answer.places])
        others = np.setdiff1d(np.arange(self.unknowns), excluded)
        return np.concatenate([others, answer.places]).astype(int)

    def variations(self, question: Question, answer: Believed, more: np.ndarray | None = None) -> np.ndarray:
        """Change of all coefficients with an answer, relative to "no effect", shape (c, 1 + p).

        The first column is the expected change, the others deviations of the answer's p coefficients by one
        standard deviation each, to which the other unknowns adapt.

        Args:
            question: Question.
            answer: One of its answers.
            more: Products of all columns in a further run that shows what is expected, shape (c, c).
        """
        held, count = self.held_by(question, answer), len(answer.places)
        matrix, mean = self.posterior(held)
        if more is not None:
            matrix = matrix + more[np.ix_(held, held)]
        others, own = slice(0, len(held) - count), slice(len(held) - count, None)
        adaptation = -solve(factored(matrix[others, others]), matrix[others, own])
        precision = matrix[own, own] + matrix[own, others] @ adaptation
        covariance = solve(factored(precision), np.eye(count))
        variations = np.zeros((len(self.gram), 1 + count))
        spread = np.column_stack([mean[own], root(covariance)])
        variations[held] = np.concatenate([adaptation, np.eye(count)]) @ spread
        return variations

    def stance(self, question: Question, answer: Believed) -> Stance:
        """Coefficients of all columns if an answer is true."""
        held, none = self.held_by(question, answer), np.zeros((len(self.gram), 0))
        mean = np.zeros(len(self.gram))
        mean[answer.places] = self.mean[answer.places]
        if not len(answer.places):
            return Stance(held, self.precision[held], mean, none)
        variations = np.zeros((len(self.gram), 1 + len(answer.places)))
        variations[answer.places] = self.variations(question, answer)[answer.places]
        return Stance(held, self.precision[held], mean, variations)


def separations(stances: Sequence[Stance], gram: np.ndarray, strain: bool = True) -> np.ndarray:
    """Chi-squared by which each rival (column) fails to explain each answer (row), shape (m, m).

    It is the chi-squared of the answer's torque that the rival leaves unexplained, plus that of the prior
    deviations this requires. A formula is wrong by `FORMULA` of its torque. Since an error of that size may
    resemble the unexplained part, it limits the chi-squared, however long the runs are.

    Args:
        stances: Coefficients with each answer.
        gram: Products of all columns over the runs, shape (c, c).
        strain: Whether to count deviations from priors; not if they have been counted already.
    """
    chi_squared = np.zeros((len(stances), len(stances)))
    for rival, other in enumerate(stances):
        columns = gram[:, other.held]
        factor = factored(np.diag(other.precision) + columns[other.held])
        for true, stance in enumerate(stances):
            if true == rival or not stance.variations.size:
                continue
            variations = stance.variations.copy()
            power = float(np.sum(variations * (gram @ variations)))
            variations[:, 0] -= other.mean
            products = gram @ variations
            replacement = solve(factor, products[other.held])
            strained = float(np.sum(other.precision[:, None] * replacement**2))
            explained = np.sum(replacement * products[other.held])
            unexplained = float(np.sum(variations * products) - explained) - strained
            chi_squared[true, rival] = strain * strained + max(unexplained, 0.0) / (1.0 + FORMULA**2 * power)
    return chi_squared
