"""Belief: what a diagnosis leaves open, and with which probabilities and precisions."""

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
    """One answer to a question.

    Attributes:
        effect: Name in the vocabulary; empty for nothing.
        joints: Where, from 0.
        probability: [-].
        places: Places of its coefficients among all columns, (p,).
    """

    effect: str
    joints: tuple[int, ...]
    probability: float
    places: np.ndarray


class Question(NamedTuple):
    """What may explain one misfit, or whether one effect is there.

    Attributes:
        answers: The most probable first; their probabilities add to one.
        seen: Whether a misfit asks it, or values that are strained beyond their tolerances; else nothing does
            but that no run so far could show the effect.
        own: Unknowns that belong to the finding in question, not there for other answers, (p,); none where
            nothing was found, and something is only suspected.
    """

    answers: tuple[Believed, ...]
    seen: bool
    own: np.ndarray

    @property
    def probabilities(self) -> np.ndarray:
        """Of the answers, shape (m,)."""
        return np.array([one.probability for one in self.answers])

    @property
    def settling(self) -> np.ndarray:
        """Probability from which on each answer settles it, shape (m,).

        That a finding is nothing does not, for it would be none then. That nothing is where something is only
        suspected does, where it is as much likelier than all else as what has a name.
        """
        nothing = np.inf if self.own.size else NAMED
        return np.array([CREDIBLE if one.effect else nothing for one in self.answers])

    @property
    def settled(self) -> bool:
        """Whether one of its answers settles it."""
        return bool(np.any(self.probabilities >= self.settling))


class Stance(NamedTuple):
    """All columns' coefficients if one answer is true.

    Attributes:
        held: Columns that are there, (s,).
        precision: Precision of their priors, shape (s,).
        mean: Mean of the priors of its own, beside the other unknowns, of all columns (c,).
        ways: Its own coefficients, in the first column, and how they may differ from these by one standard
            deviation, in each of the others, of all columns, shape (c, w).
    """

    held: np.ndarray
    precision: np.ndarray
    mean: np.ndarray
    ways: np.ndarray


@dataclass(frozen=True, eq=False)
class Belief:
    """The posterior of a diagnosis: unknowns, then coefficients of all suspects, c columns together.

    Attributes:
        search: Search of the diagnosis.
        suspects: What is not in the model and may be there.
        gram: Products of all columns over the runs so far, weighted as the diagnosis did, shape (c, c).
        right: Right-hand side of the normal equations, shape (c,).
        precision: Precision of priors, shape (c,); zero where nothing is known.
        mean: Mean of priors, shape (c,).
        weight: Weight of a row of each joint of a further run, shape (n,) [1 / (N m)^2].
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

    def ways(self, question: Question, answer: Believed, more: np.ndarray | None = None) -> np.ndarray:
        """What an answer changes of all coefficients, shape (c, 1 + p), beside that nothing is there.

        The change that is expected, and those by which its own p coefficients may differ from that by one
        standard deviation each; the other unknowns follow. With the products of a further run (c, c) that
        shows what is expected.
        """
        held, count = self.held_by(question, answer), len(answer.places)
        matrix, mean = self.posterior(held)
        if more is not None:
            matrix = matrix + more[np.ix_(held, held)]
        rest, own = slice(0, len(held) - count), slice(len(held) - count, None)
        followed = -solve(factored(matrix[rest, rest]), matrix[rest, own])
        apart = matrix[own, own] + matrix[own, rest] @ followed
        covariance = solve(factored(apart), np.eye(count))
        found = np.zeros((len(self.gram), 1 + count))
        spread = np.column_stack([mean[own], root(covariance)])
        found[held] = np.concatenate([followed, np.eye(count)]) @ spread
        return found

    def stance(self, question: Question, answer: Believed) -> Stance:
        """What is believed if an answer is true."""
        held, none = self.held_by(question, answer), np.zeros((len(self.gram), 0))
        own = np.zeros(len(self.gram))
        own[answer.places] = self.mean[answer.places]
        if not len(answer.places):
            return Stance(held, self.precision[held], own, none)
        ways = np.zeros((len(self.gram), 1 + len(answer.places)))
        ways[answer.places] = self.ways(question, answer)[answer.places]
        return Stance(held, self.precision[held], own, ways)


def separations(stances: Sequence[Stance], gram: np.ndarray, strain: bool = True) -> np.ndarray:
    """How far each answer (row) is from being explained by each other one (column), shape (m, m).

    The chi-squared of its torque that the other leaves over runs of these products of columns (c, c), and
    that of what its coefficients and the other unknowns have to be for that, by their priors. The formula of
    an effect is wrong by `FORMULA` of its torque: all of that may look like what the other leaves, however
    long the runs are. Without `strain`, priors say nothing: those that have spoken already.
    """
    found = np.zeros((len(stances), len(stances)))
    for rival, other in enumerate(stances):
        columns = gram[:, other.held]
        factor = factored(np.diag(other.precision) + columns[other.held])
        for true, one in enumerate(stances):
            if true == rival or not one.ways.size:
                continue
            ways = one.ways.copy()
            power = float(np.sum(ways * (gram @ ways)))
            ways[:, 0] -= other.mean
            whole = gram @ ways
            taken = solve(factor, whole[other.held])
            strained = float(np.sum(other.precision[:, None] * taken**2))
            left = float(np.sum(ways * whole) - np.sum(taken * whole[other.held])) - strained
            found[true, rival] = strain * strained + max(left, 0.0) / (1.0 + FORMULA**2 * power)
    return found
