"""Scene: what a search looks at, and what is credible in it beside what was found."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..model import Model
from .candidate import Candidate, Thinned
from .candidates import candidates
from .candidates.contact import Reach, touches
from .driven import Driven
from .found import Found
from .hypothesis import Hypothesis
from .nuisances import with_nuisances
from .ranking import ranked
from .reloading import UNSETTLING, Known, alike, anew
from .rows import Rows, model_rows
from .solution import Solution
from .solving import solved, with_found

Asked = Sequence[tuple[Candidate, Thinned]]


@dataclass(frozen=True, eq=False)
class Scene:
    """What a search looks at.

    Attributes:
        model: As believed.
        runs: Those that may be fitted, with the load that gears transmit as far as it is known.
        rows: Of these runs, with nuisances and without findings.
        asked: All hypotheses that do not depend on what is left.
        reaches: Of a force on the flange, in each run.
        base: Rows with the model's own unknowns alone.
        known: What makes the torque and the load of any run.
    """

    model: Model
    runs: tuple[Driven, ...]
    rows: Rows
    asked: Asked
    reaches: tuple[Reach, ...]
    base: Rows
    known: Known

    @classmethod
    def of(cls, model: Model, runs: Sequence[Driven]) -> "Scene":
        """With the load of a first fit."""
        base = model_rows(model, runs)
        known = Known.after(model, solved(base)).of(runs)
        runs = tuple(known.on(run) for run in runs)
        asked = [(candidate, Thinned.of(candidate, runs)) for candidate in candidates(model)]
        reaches = tuple(Reach.of(model, run) for run in runs)
        return cls(model, runs, with_nuisances(base, model, runs), asked, reaches, base, known)

    @property
    def count(self) -> int:
        """Number of hypotheses; a touch of the arm, which may be any time, is one."""
        return len({candidate.key for candidate, _ in self.asked}) + 1

    @property
    def tried(self) -> dict[str, int]:
        """Effects that these runs can be asked for, with how many hypotheses there are of each."""
        keys = {candidate.key for candidate, columns in self.asked if not columns.empty}
        return dict(Counter(effect for effect, _ in keys)) | {"contact_event": 1}

    def solution(self, found: Sequence[Found]) -> Solution:
        """With the columns of what was found."""
        pairs = [(one.hypothesis, one.hypothesis.columns) for one in found]
        return solved(with_found(self.rows, pairs))

    def ranked(self, found: Sequence[Found]) -> list[Hypothesis]:
        """What else there may be, the most credible first."""
        taken = {one.hypothesis.candidate.key for one in found}
        solution = self.solution(found)
        windows = touches(self.model, solution, self.runs, self.reaches)
        touched = [(one, Thinned.of(one, self.runs)) for one in windows]
        return ranked(
            solution, [one for one in [*self.asked, *touched] if one[0].key not in taken], self.runs
        )

    def bearing(self, found: Sequence[Found]) -> tuple["Scene", list[Found]]:
        """The same, and the findings, with the load that gears transmit beside what was found."""
        unsettled = any(one.hypothesis.candidate.effect in UNSETTLING for one in found)
        if not unsettled and self.known.first:
            return self, list(found)
        hypotheses = [one.hypothesis for one in found]
        known = Known.after(self.model, self.solution(found), hypotheses).of(self.runs)
        runs = tuple(known.on(run) for run in self.runs)
        if alike(self.runs, runs):
            return self, list(found)
        fresh = [
            one._replace(hypothesis=replace(old, columns=anew(old.candidate, old.columns, runs)))
            for one, old in zip(found, hypotheses, strict=True)
        ]
        asked = [(candidate, anew(candidate, columns, runs)) for candidate, columns in self.asked]
        rows = with_nuisances(self.base, self.model, runs)
        return replace(self, runs=runs, rows=rows, asked=asked, known=known), fresh
