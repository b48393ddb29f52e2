"""Problem: the input of a search: runs with the load of their gears, rows, blocks and all candidates."""

import operator
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin

from ...effects import TorqueCurve
from ...model import Model
from ..blocks.blocks import BlockRows, Blocks
from ..blocks.prediction import Prediction
from ..candidates import candidates
from ..candidates.bodies import with_found
from ..candidates.contact_event import FlangeTorque
from ..candidates.curves import curve
from ..questions.block_answer import Answer
from ..questions.candidate import Candidate, Thinned
from ..runs.driven import Driven
from ..runs.rows import Rows, model_rows, with_nuisances
from ..runs.usable import HELD_OUT
from .mismatch import Place, mismatches, splines_of, unknowns_of

ALIKE = 2e-3
"""Relative change of a load that is ignored [-]: it shifts the crossing of backlash by a few milliseconds."""
RECENT = 4
"""Number of predictions in the cache, of tens of megabytes each."""
Pairs = list[tuple[Candidate, Thinned]]


@dataclass(frozen=True, eq=False)
class Known:
    """Fitted model and findings, from which the torque and the load of any run follow."""

    model: Model  # nominal model
    values: np.ndarray  # fitted parameters, shape (p,)
    first: bool = True  # whether this is the first fit, without findings
    carried: tuple[tuple[Candidate, np.ndarray], ...] = ()  # findings that load the gears, and coefficients
    peak: np.ndarray | None = None  # largest torque of each joint in the fitted runs, (n,) [N m]

    @classmethod
    def after(cls, model: Model, unknowns: np.ndarray, findings: Sequence[Answer] = ()) -> "Known":
        """From unknowns (b,), the last of which are the coefficients of the findings."""
        ends = np.cumsum([len(answer.values) for answer in findings], dtype=int)
        coefficients = np.split(unknowns[len(unknowns) - (ends[-1] if findings else 0) :], ends)
        pairs = zip(findings, coefficients, strict=False)
        carried = tuple((answer.candidate, values) for answer, values in pairs if answer.candidate.carried)
        return cls(model, model.nominal_values + unknowns[: len(model.names)], not findings, carried)

    def of(self, runs: Sequence[Driven]) -> "tuple[Known, tuple[Driven, ...]]":
        """A copy with the largest torques of the fitted runs, and all runs with their torque and load."""
        fresh = [self.on(run) for run in runs]
        torques = [np.max(np.abs(run.torque), axis=0) for run in fresh if run.role != HELD_OUT]
        peak = np.max(torques, axis=0)
        return replace(self, peak=peak), tuple(replace(run, peak=peak) for run in fresh)

    def on(self, run: Driven) -> Driven:
        """The run with the torque and load of this fit."""
        fresh, robot = run.after(self.model, self.values), self.model.robot
        stated = robot.inertias_stated and not self.first
        fresh = replace(fresh, found=self._bodies(fresh) if stated else None)
        for candidate, values in self.carried:
            torque = candidate.columns(fresh) @ values
            fresh = fresh.with_more_load(np.linalg.solve(robot.to_motors, torque.T).T, torque)
            if np.any(torque):  # a body may be on the flange in some runs only
                fresh = replace(fresh, found=with_found(fresh.bodies, robot, candidate, values))
        return replace(fresh, peak=self.peak)

    def _bodies(self, run: Driven) -> pin.Model | None:
        """Arm with the fitted bodies of a run; None unless all of them have a mass."""
        nominal, (fitted, _) = run.unloaded.bodies, self.model.bodies_apart(self.values, run.motion.payload)
        pairs = zip(nominal.inertias, fitted.inertias, strict=True)
        return fitted if all(body.mass > 0.0 or not stated.mass for stated, body in pairs) else None


def load_unchanged(before: Sequence[Driven], after: Sequence[Driven]) -> bool:
    """Whether the load of the runs has hardly changed."""
    pairs = [(old.motion.load, new.motion.load) for old, new in zip(before, after, strict=True)]
    load = np.concatenate([old for old, _ in pairs])
    change = np.concatenate([new - old for old, new in pairs])
    return bool(np.all(np.linalg.norm(change, axis=0) <= ALIKE * np.linalg.norm(load, axis=0)))


def anew(candidate: Candidate, columns: Thinned, runs: Sequence[Driven]) -> Thinned:
    """Columns of a candidate over runs whose load has changed; those of a measured gear always stay zero."""
    changed = candidate.loaded and bool(np.any(columns.values))
    return Thinned.of(candidate, runs) if changed else columns


@dataclass(frozen=True, eq=False)
class Problem:
    """Input of a search."""

    model: Model  # nominal model
    runs: tuple[Driven, ...]  # fitted runs, then held-out runs
    blocks: Blocks  # pieces of the runs
    base: Rows  # rows with the unknowns of the model alone
    rows: Rows  # rows with nuisances too
    candidates: Pairs  # all candidates that do not depend on the residual, at the load where last formed
    known: Known  # fit from which the torque and the load of any run follow
    flange_torques: tuple[FlangeTorque, ...]  # motor torque per unit of force on the flange, for each run
    moved: bool = False  # whether the load differs from that of the first fit
    # caches that problems at the same load share: columns of candidates, and of those that residuals suggest
    formed: WeakKeyDictionary[Candidate, Thinned] = field(default_factory=WeakKeyDictionary)
    suggested: dict[object, Thinned] = field(default_factory=dict)

    @classmethod
    def of(cls, model: Model, runs: Sequence[Driven]) -> "Problem":
        """Set up the problem with the load of a first fit."""
        runs = sorted(runs, key=lambda run: run.role == HELD_OUT)
        blocks, base = Blocks.of(runs, HELD_OUT), model_rows(model, runs)
        first = Known.after(model, _predicted(base, blocks, runs).values)
        values, (known, loaded) = first.values, first.of(runs)
        pairs = [(candidate, Thinned.of(candidate, loaded)) for candidate in candidates(model)]
        pairs = [pair for pair in pairs if not pair[1].empty]
        base = _rows(model, loaded, values, base)
        rows = with_nuisances(base, model, loaded, values)
        flange_torques = tuple(FlangeTorque.of(model, run) for run in loaded)
        return cls(model, loaded, blocks, base, rows, pairs, known, flange_torques)

    def with_candidates(self, more: Iterable[Candidate]) -> "Problem":
        """This problem with further candidates, except those that it has."""

        def identity(candidate: Candidate) -> tuple[object, ...]:
            return candidate.key, candidate.names, *candidate.shape.items()

        present = {identity(candidate) for candidate, _ in self.candidates}
        fresh = [candidate for candidate in more if identity(candidate) not in present]
        added = [(candidate, Thinned.of(candidate, self.runs)) for candidate in fresh]
        self.formed.update(added)
        return replace(self, candidates=[*self.candidates, *added]) if added else self

    def with_priors(self, model: Model) -> "Problem":
        """This problem with the priors of another model, which has the same parameters."""
        std = np.array([prior.std for prior in model.priors])
        rows, base = (
            replace(rows, std=np.append(std, rows.std[len(std) :])) for rows in (self.rows, self.base)
        )
        return replace(self, model=model, rows=rows, base=base)

    def with_load_of(self, other: "Problem") -> "Problem":
        """This problem with the load, the runs and the candidates of another one that has other priors."""
        return other.with_priors(self.model)

    def columns_of(self, candidate: Candidate) -> Thinned:
        """Columns of a candidate, from a cache: the residual suggests some candidates again and again."""
        name = (candidate.key, tuple(candidate.shape.items()))
        if name not in self.suggested:
            self.suggested[name] = Thinned.of(candidate, self.runs)
        return self.suggested[name]

    def columns_at_load(self, candidate: Candidate, columns: Thinned) -> Thinned:
        """Columns of a candidate at the load of these runs, computed once."""
        if candidate not in self.formed:
            self.formed[candidate] = anew(candidate, columns, self.runs)
        return self.formed[candidate]

    def pairs(self, wanted: Callable[[Candidate, np.ndarray], bool]) -> Pairs:
        """Candidates that `wanted` accepts, given the candidate and its joints, with columns at the load."""
        return self.at_load([pair for pair in self.candidates if wanted(pair[0], pair[1].joints)])

    def at_load(self, pairs: Pairs) -> Pairs:
        """The pairs with columns at the load of these runs."""
        if not self.moved:
            return pairs
        return [(candidate, self.columns_at_load(candidate, columns)) for candidate, columns in pairs]

    @property
    def last_formed(self) -> Pairs:
        """All candidates with the columns that were formed last, at this load or an earlier one."""
        pairs = ((candidate, columns, self.formed.get(candidate)) for candidate, columns in self.candidates)
        return [(c, columns if here is None or here.empty else here) for c, columns, here in pairs]

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
        """Effects that these runs can test, and the number of hypotheses of each."""
        keys = dict.fromkeys(candidate.key for candidate, _ in self.candidates)
        return dict(Counter(effect for effect, *_ in keys))

    def prediction(self, findings: Sequence[Answer], similar: Prediction | None = None) -> Prediction:
        """Prediction with the columns of findings; its noise estimate starts from that of a similar one."""
        if not findings:
            return self.without_findings
        for answers, prediction in self._recent:
            if len(answers) == len(findings) and all(map(operator.is_, answers, findings)):
                return prediction
        formulas = mismatches(findings, self._curve)
        splines = {mismatch.place: self._curve(mismatch.place)[1] for mismatch in formulas}
        rows = with_findings(self.rows, findings, unknowns_of(formulas, findings, splines))
        sums = self._sums.plus(rows, len(self.rows.std))
        prediction = _predicted(rows, self.blocks, self.runs, similar, sums, self.without_findings.errors)
        self._recent.appendleft((tuple(findings), prediction))
        return prediction

    def _curve(self, place: Place) -> tuple[TorqueCurve, np.ndarray]:
        """The curve at a place, and its splines (r, n, s)."""
        if place not in self._curves:
            effect = curve(self.model, *place, self.runs)
            self._curves[place] = effect, splines_of(effect, self.model, self.runs)
        return self._curves[place]

    @cached_property
    def _curves(self) -> dict[Place, tuple[TorqueCurve, np.ndarray]]:
        """Curves and splines by place, computed on first use."""
        return {}

    def forget(self) -> None:
        """Free the memory of predictions and products, once another problem has replaced this one."""
        self._recent.clear()
        self.formed.clear()

    @cached_property
    def _recent(self) -> deque[tuple[tuple[Answer, ...], Prediction]]:
        """Cache of the latest predictions with their findings: a search soon needs most of them again."""
        return deque(maxlen=RECENT)

    @cached_property
    def without_findings(self) -> Prediction:
        """Prediction of the baseline: the unknowns of the model and nuisances, without findings."""
        return _predicted(self.rows, self.blocks, self.runs, None, self._sums)

    @cached_property
    def _sums(self) -> BlockRows:
        """Rows without findings, arranged by block, which all predictions share."""
        return BlockRows.of(self.rows, self.blocks)

    def excluding(self, excluded: np.ndarray) -> "Problem":
        """This problem without the marked rows (r,), which are neither fitted nor predicted."""
        weight = self.rows.weight * ~excluded[:, None]
        return replace(self, rows=replace(self.rows, weight=weight))

    def at_load_of(self, findings: Sequence[Answer]) -> "tuple[Problem, list[Answer]]":
        """This problem and the findings, both at the load that the gears transmit with the findings."""
        # A fit without load-dependent friction mistakes it for gravity, which makes its load wrong.
        affected = any(a.candidate.carried or a.candidate.loaded or a.candidate.reloads for a in findings)
        if not affected and self.known.first:
            return self, list(findings)
        known, runs = Known.after(self.model, self.prediction(findings).values, findings).of(self.runs)
        if load_unchanged(self.runs, runs):
            return self, list(findings)
        fresh = [replace(answer, columns=anew(answer.candidate, answer.columns, runs)) for answer in findings]
        base = _rows(self.model, runs, known.values, self.base)
        rows = with_nuisances(base, self.model, runs, known.values)
        rows = replace(rows, weight=self.rows.weight)
        caches: dict[str, Any] = {"formed": WeakKeyDictionary(), "suggested": {}, "moved": True}
        moved = replace(
            self, runs=runs, base=base, rows=rows, candidates=self.last_formed, known=known, **caches
        )
        return moved, fresh


def _rows(model: Model, runs: Sequence[Driven], values: np.ndarray, before: Rows) -> Rows:
    """Rows at the load given by parameters (p,); unchanged if no friction of the model depends on load."""
    return model_rows(model, runs, values) if any(effect.needs_load for effect in model.effects) else before


def with_findings(
    rows: Rows, findings: Sequence[Answer], curves: Sequence[tuple[list[str], np.ndarray, np.ndarray]] = ()
) -> Rows:
    """Rows with the unknowns of curves (names, columns, standard deviations), then those of findings."""
    if not findings:
        return rows
    joints, of_curves = rows.difference.shape[1], [name for names, _, _ in curves for name in names]
    of_findings = [(answer.candidate.effect, name) for answer in findings for name in answer.candidate.names]
    return rows.plus(
        [*of_curves, *map(" ".join, of_findings)],
        np.concatenate(
            [*(c for _, c, _ in curves), *(answer.columns.everywhere(joints) for answer in findings)], axis=2
        ),
        np.concatenate([*(std for *_, std in curves), *(answer.std for answer in findings)]),
        np.concatenate([np.zeros(len(of_curves)), *(answer.mean for answer in findings)]),
        [-np.inf] * len(of_curves) + [limit for answer in findings for limit in answer.candidate.lower],
    )


def _predicted(
    rows: Rows,
    blocks: Blocks,
    runs: Sequence[Driven],
    similar: Prediction | None = None,
    sums: BlockRows | None = None,
    nominal: np.ndarray | None = None,
) -> Prediction:
    rate, weighting = runs[0].prepared.decimation.output_rate, similar.weighting if similar else None
    return Prediction.of(rows, blocks, rate, weighting, sums, nominal)
