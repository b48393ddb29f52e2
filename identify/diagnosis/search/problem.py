"""Problem: what a search looks at: the runs with the load of their gears, rows, blocks and all candidates."""

import operator
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from ...effects import TorqueCurve
from ...model import Model
from ...positive_definite import solve
from ..blocks.blocks import Blocks, BlockSums
from ..blocks.prediction import CERTAIN, Prediction, factored
from ..candidates import candidates
from ..candidates.contact_event import Reach
from ..candidates.curves import curve
from ..questions.block_answer import Answer
from ..questions.candidate import Candidate, Thinned
from ..questions.shape import Shaped, asked_again
from ..runs.driven import Driven
from ..runs.rows import CLOCK, REVERSAL, Rows, model_rows, with_nuisances
from ..runs.usable import HELD_OUT
from .mismatch import Mismatch, Place, mismatches, splines_of, with_mismatches

ALIKE = 2e-3
"""Change of a load over the load [-] that moves no link: its play is crossed some milliseconds sooner."""
RECENT = 4
"""Predictions that are kept, of tens of megabytes each."""
FREE = (REVERSAL, CLOCK)
"""How nuisances begin that are fitted even where the model is taken as nominal."""

Asked = list[tuple[Candidate, Thinned]]


@dataclass(frozen=True, eq=False)
class Known:
    """What makes the torque and the load of any run."""

    model: Model  # nominal
    values: np.ndarray  # its parameters as fitted, shape (p,)
    first: bool = True  # whether nothing was found yet that matters for it
    carried: tuple[tuple[Candidate, np.ndarray], ...] = ()  # findings that gears carry, coefficients
    peak: np.ndarray | None = None  # largest torque of each joint in the fitted runs, (n,) [N m]

    @classmethod
    def after(cls, model: Model, unknowns: np.ndarray, found: Sequence[Answer] = ()) -> "Known":
        """From unknowns (b,) the last of which are what was found."""
        ends = np.cumsum([len(one.values) for one in found], dtype=int)
        own = np.split(unknowns[len(unknowns) - (ends[-1] if found else 0) :], ends)
        pairs = zip(found, own, strict=False)
        carried = tuple((one.candidate, values) for one, values in pairs if one.candidate.carried)
        return cls(model, model.nominal_values + unknowns[: len(model.names)], not found, carried)

    def of(self, runs: Sequence[Driven]) -> "tuple[Known, tuple[Driven, ...]]":
        """This with the largest torques of the fitted runs, and all runs with their torque and load."""
        fresh = [self.on(run) for run in runs]
        torques = [np.max(np.abs(run.torque), axis=0) for run in fresh if run.role != HELD_OUT]
        peak = np.max(torques, axis=0)
        return replace(self, peak=peak), tuple(replace(run, peak=peak) for run in fresh)

    def on(self, run: Driven) -> Driven:
        """A run with that torque and load."""
        fresh = run.after(self.model, self.values)
        for candidate, values in self.carried:
            torque = candidate.columns(fresh) @ values
            on_joints = np.linalg.solve(self.model.robot.to_motors, torque.T).T
            fresh = fresh.bearing(on_joints, torque)
        return replace(fresh, peak=self.peak)


def alike(before: Sequence[Driven], after: Sequence[Driven]) -> bool:
    """Whether the load has hardly changed."""
    pairs = [(one.motion.load, other.motion.load) for one, other in zip(before, after, strict=True)]
    load = np.concatenate([one for one, _ in pairs])
    change = np.concatenate([other - one for one, other in pairs])
    return bool(np.all(np.linalg.norm(change, axis=0) <= ALIKE * np.linalg.norm(load, axis=0)))


def anew(candidate: Candidate, columns: Thinned, runs: Sequence[Driven]) -> Thinned:
    """Columns of a candidate over runs whose load has changed; those of a measured gear are zero at any."""
    changed = candidate.loaded and bool(np.any(columns.values))
    return Thinned.of(candidate, runs) if changed else columns


@dataclass(frozen=True, eq=False)
class Problem:
    """What a search looks at."""

    model: Model  # nominal
    runs: tuple[Driven, ...]  # those that are fitted, then those that are only predicted
    blocks: Blocks  # pieces of them
    base: Rows  # rows with the model's own unknowns alone
    rows: Rows  # the same with nuisances
    asked: Asked  # all candidates that do not depend on what is left, at the load of the first fit
    known: Known  # what makes the torque and the load of any run
    reaches: tuple[Reach, ...]  # what a force on the flange asks of the motors of each run
    moved: bool = False  # whether the load is another than that of the first fit

    @classmethod
    def of(cls, model: Model, runs: Sequence[Driven], before: Sequence[Shaped] = ()) -> "Problem":
        """With the load of a first fit; shapes that were found before are asked for too."""
        runs = sorted(runs, key=lambda run: run.role == HELD_OUT)
        blocks, base = Blocks.of(runs, HELD_OUT), model_rows(model, runs)
        first = Known.after(model, _predicted(base, blocks, runs).values)
        values, (known, loaded) = first.values, first.of(runs)
        grid = list(candidates(model))
        every = [*grid, *asked_again(grid, before)]
        asked = [(candidate, Thinned.of(candidate, loaded)) for candidate in every]
        asked = [pair for pair in asked if not pair[1].empty]
        base = _rows(model, loaded, values, base)
        rows = with_nuisances(base, model, loaded, values)
        reaches = tuple(Reach.of(model, run) for run in loaded)
        return cls(model, loaded, blocks, base, rows, asked, known, reaches)

    def asking(self, more: Iterable[Candidate]) -> "Problem":
        """This problem with further candidates."""
        asked = [(candidate, Thinned.of(candidate, self.runs)) for candidate in more]
        return replace(self, asked=[*self.asked, *asked]) if asked else self

    def columns_of(self, candidate: Candidate) -> Thinned:
        """Columns of a candidate; those of one that is found among what is left again and again are kept."""
        name = (candidate.key, tuple(candidate.shape.items()))
        if name not in self._columns:
            self._columns[name] = Thinned.of(candidate, self.runs)
        return self._columns[name]

    def columns_anew(self, candidate: Candidate, columns: Thinned) -> Thinned:
        """Columns of a candidate at the load of these runs, worked out once."""
        if candidate not in self._anew:
            self._anew[candidate] = anew(candidate, columns, self.runs)
        return self._anew[candidate]

    @cached_property
    def _columns(self) -> dict[object, Thinned]:
        return {}

    @cached_property
    def _anew(self) -> WeakKeyDictionary[Candidate, Thinned]:
        return WeakKeyDictionary()

    def pairs(self, wanted: Callable[[Candidate, np.ndarray], bool]) -> Asked:
        """Candidates that are wanted, by themselves and their joints, with columns at the load."""
        return [
            (candidate, self._at_load(candidate, columns))
            for candidate, columns in self.asked
            if wanted(candidate, columns.joints)
        ]

    def _at_load(self, candidate: Candidate, columns: Thinned) -> Thinned:
        """Columns at the load of the runs, formed when they are first asked for."""
        if not self.moved:
            return columns
        if candidate not in self._renewed:
            self._renewed[candidate] = anew(candidate, columns, self.runs)
        return self._renewed[candidate]

    @cached_property
    def _renewed(self) -> dict[Candidate, Thinned]:
        """Columns that were asked for at another load than that of the first fit."""
        return {}

    @property
    def fitted(self) -> tuple[Driven, ...]:
        """Runs that are fitted."""
        return tuple(run for run in self.runs if run.role != HELD_OUT)

    @property
    def held_out(self) -> tuple[Driven, ...]:
        """Runs that are only predicted."""
        return tuple(run for run in self.runs if run.role == HELD_OUT)

    @property
    def tried(self) -> dict[str, int]:
        """Effects that these runs can be asked for, with how many hypotheses there are of each."""
        return dict(Counter(effect for effect, *_ in {candidate.key for candidate, _ in self.asked}))

    def prediction(self, found: Sequence[Answer], near: Prediction | None = None) -> Prediction:
        """With the columns of what was found, its noise searched from that of a like prediction on."""
        if not found:
            return self.without_findings
        for answers, prediction in self._recent:
            if len(answers) == len(found) and all(map(operator.is_, answers, found)):
                return prediction
        rows = with_found(self._with_mismatches(found), found)
        sums = self._sums.plus(rows, len(self.rows.std))
        prediction = _predicted(rows, self.blocks, self.runs, near, sums, self.without_findings.errors)
        self._recent.appendleft((tuple(found), prediction))
        return prediction

    def mismatches(self, found: Sequence[Answer]) -> list[Mismatch]:
        """By how much the formulas of what was found may be wrong."""
        return mismatches(found, self._curve)

    def _with_mismatches(self, found: Sequence[Answer]) -> Rows:
        """The rows with unknowns by which the formulas of what was found may be wrong."""
        every = self.mismatches(found)
        return with_mismatches(
            self.rows, every, found, {one.place: self._curve(one.place)[1] for one in every}
        )

    def _curve(self, place: Place) -> tuple[TorqueCurve, np.ndarray]:
        """The curve at a place, and its splines (r, n, s)."""
        if place not in self._curves:
            effect = curve(self.model, *place, self.runs)
            self._curves[place] = effect, splines_of(effect, self.model, self.runs)
        return self._curves[place]

    @cached_property
    def _curves(self) -> dict[Place, tuple[TorqueCurve, np.ndarray]]:
        """Those that were asked for."""
        return {}

    def forget(self) -> None:
        """Free the memory of predictions and products, once another problem has replaced this one."""
        self._recent.clear()
        self._renewed.clear()
        self._sums.known.clear()

    @cached_property
    def _recent(self) -> deque[tuple[tuple[Answer, ...], Prediction]]:
        """The latest predictions, with their findings: a search asks for most of them again at once."""
        return deque(maxlen=RECENT)

    @cached_property
    def without_findings(self) -> Prediction:
        """With the model's own unknowns alone."""
        return _predicted(self.rows, self.blocks, self.runs, None, self._sums)

    @cached_property
    def _sums(self) -> BlockSums:
        """Products that stay the same whatever is found."""
        return BlockSums.of(self.rows, self.blocks)

    @property
    def stated(self) -> np.ndarray:
        """Which unknowns of its rows the model states a value of, shape (b,)."""
        guesses = [effect for effect in self.model.effects if effect.guessed]
        guessed = {one.name for effect in guesses for one in effect.parameters(self.model.robot)}
        free = np.array([name in guessed or name.startswith(FREE) for name in self.rows.names])
        if not self.model.robot.inertias_stated:
            free[: len(self.model.names)] = True
        return ~free & np.isfinite(self.rows.std)

    def at_nominal(self) -> "Problem":
        """This problem with all that the model states held at its nominal value."""
        return replace(self, rows=replace(self.rows, std=np.where(self.stated, CERTAIN, self.rows.std)))

    def nominal_unknowns(self, without_findings: Prediction) -> np.ndarray:
        """Unknowns (b,) of the nominal model, without findings; what is unstated is fitted."""
        rows = without_findings.rows
        matrix, right = without_findings.normal
        precision = np.where(self.stated, CERTAIN**-2.0, 0.0)
        return solve(factored(matrix + np.diag(precision)), right + precision * rows.mean)

    def without(self, aside: np.ndarray) -> "Problem":
        """This problem without some rows (r,), which are neither fitted nor predicted."""
        weight = self.rows.weight * ~aside[:, None]
        return replace(self, rows=replace(self.rows, weight=weight))

    def bearing(self, found: Sequence[Answer]) -> "tuple[Problem, list[Answer]]":
        """This problem, and the findings, with the load that gears transmit beside what was found."""
        # A fit without friction by load takes it for gravity, by which its load is wrong.
        unsettled = any(one.candidate.carried or one.candidate.loaded for one in found)
        if not unsettled and self.known.first:
            return self, list(found)
        known, runs = Known.after(self.model, self.prediction(found).values, found).of(self.runs)
        if alike(self.runs, runs):
            return self, list(found)
        fresh = [replace(one, columns=anew(one.candidate, one.columns, runs)) for one in found]
        base = _rows(self.model, runs, known.values, self.base)
        rows = with_nuisances(base, self.model, runs, known.values)
        rows = replace(rows, weight=self.rows.weight)
        return replace(self, runs=runs, base=base, rows=rows, moved=True, known=known), fresh


def _rows(model: Model, runs: Sequence[Driven], values: np.ndarray, before: Rows) -> Rows:
    """Rows at the load by some parameters (p,); those before where no friction of the model depends on it."""
    return model_rows(model, runs, values) if any(one.needs_load for one in model.effects) else before


def with_found(rows: Rows, found: Sequence[Answer]) -> Rows:
    """Rows with the columns of what was found."""
    if not found:
        return rows
    joints = rows.difference.shape[1]
    return rows.plus(
        [f"{one.candidate.effect} {name}" for one in found for name in one.candidate.names],
        np.concatenate([one.columns.everywhere(joints) for one in found], axis=2),
        np.concatenate([one.std for one in found]),
        np.concatenate([one.mean for one in found]),
        [limit for one in found for limit in one.candidate.lower],
    )


def _predicted(
    rows: Rows,
    blocks: Blocks,
    runs: Sequence[Driven],
    near: Prediction | None = None,
    sums: BlockSums | None = None,
    nominal: np.ndarray | None = None,
) -> Prediction:
    rate, weighting = runs[0].prepared.decimation.output_rate, near.weighting if near else None
    return Prediction.of(rows, blocks, rate, weighting, sums, nominal)
