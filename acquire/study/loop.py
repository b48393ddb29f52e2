"""The loop of a study: plan, record, identify, diagnose, choose."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from exidyn.identification.diagnosis.belief.questions import belief_of, nameless_torque
from exidyn.identification.diagnosis.belief.run_columns import RunColumns, run_columns
from exidyn.identification.diagnosis.belief.suspects import suspects_of
from exidyn.identification.diagnosis.diagnose import Diagnosed
from exidyn.identification.diagnosis.search.selected import shapes_of
from exidyn.identification.errors import ExidynError
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.model import Model
from exidyn.trajectories.next_run.choice import RUN, choose
from exidyn.trajectories.next_run.offers import Offer

from ..files.given_runs import Case, distinct_bodies
from ..run.errors import RunStopped
from ..terminal.json_output import json_text, write_whole
from ..terminal.stopwatch import with_bar
from .choice_file import RoundChoice, require_course, shape_rows, shapes_in
from .notebook import notebook
from .other_gains import other_gains, with_gains
from .rounds import CHOICE, NOTEBOOK, Round, fill_folder, next_round, rounds, tell
from .sources import Source

Identify = Callable[[Sequence[Path], Path], None]
Diagnose = Callable[[Case, Path], Diagnosed]


@dataclass(frozen=True)
class Study:
    """The subject of a study, and the functions that perform its steps.

    Attributes:
        folder: Folder of its files.
        model: Nominal model.
        source: Source of its runs.
        seconds: Maximum total time in motion [s].
        identify: Writes the files of a fit of runs, as `exidyn identify` does.
        diagnose: Writes the files of a diagnosis, as `exidyn diagnose` does.
        options: Options of the study by name; a study that ended continues if they have changed.
    """

    folder: Path
    model: Model
    source: Source
    seconds: float
    identify: Identify
    diagnose: Diagnose
    options: dict[str, Any]

    def run(self) -> RoundChoice:
        """Run until the model is decided or undecidable, or time is up; return the last choice.

        Raises:
            RunStopped: If a run was stopped before its end; the notebook reports this too.
        """
        while True:
            current = next_round(self.folder)
            try:
                choice = self._complete_round(current)
            except RunStopped as stopped:
                self._write_notebook(str(stopped))
                raise
            self._write_notebook()
            if choice.verdict != RUN:
                return choice

    def _write_notebook(self, stopped: str = "") -> None:
        """Write the notebook of all rounds so far, and why the last run was stopped early."""
        begun = rounds(self.folder)
        choices = [(past.name, choice) for past in begun if (choice := past.choice) is not None]
        require_course(self.folder, choices)
        stops = [(past.name, reason) for past in begun for reason in past.stops]
        write_whole(self.folder / NOTEBOOK, notebook(self.model.robot.name, choices, stopped, stops))

    def _complete_round(self, current: Round) -> RoundChoice:
        """Perform the steps of a round that have no result yet; return its choice."""
        earlier = rounds(self.folder)[: current.number - 1]
        current.folder.mkdir(parents=True, exist_ok=True)
        if not current.run.exists():
            last = earlier[-1].choice if earlier else None
            run_name = "the first run" if last is None else last.offers[0].name
            print(f"{current.name}: {run_name}", file=sys.stderr)
            self.source.make(current, None if last is None else last.chosen)
        rounds_so_far = [*earlier, current]
        fill_folder(current.fit, lambda part: self._fit(rounds_so_far, part))
        fill_folder(current.diagnosis, lambda part: self._diagnose_and_choose(rounds_so_far, part))
        choice = current.choice
        assert choice is not None
        return choice

    def _fit(self, rounds_so_far: Sequence[Round], part: Path) -> None:
        """Fit all runs; the study continues if they do not support a fit."""
        try:
            self.identify([past.run for past in rounds_so_far], part)
        except ExidynError as error:
            write_whole(part / "none.txt", f"{error}\n")
            tell(f"no fit: {error}")

    def _diagnose_and_choose(self, rounds_so_far: Sequence[Round], part: Path) -> None:
        """Diagnose all runs, collect the available runs, and choose the next."""
        recordings = distinct_bodies([past.recording() for past in rounds_so_far])
        last = rounds_so_far[-2].choice if len(rounds_so_far) > 1 else None
        earlier_shapes = shapes_in(last)
        file = rounds_so_far[-1].fit / "fit.json"
        fit = read_fit(file) if file.exists() else None
        gains = other_gains(fit, self.model)
        model = with_gains(self.model, gains)
        case = Case(model.robot.name, model, [("identify", run) for run in recordings], earlier_shapes)
        diagnosis, search = self.diagnose(case, part)
        offers = self.source.offers(rounds_so_far, diagnosis, fit)
        suspects, findings = suspects_of(search), [selected.answer for selected in search.selected]
        usable: list[Offer] = []
        columns: list[RunColumns] = []
        tell("predicting what each available run would show")
        for offer in with_bar(offers):
            try:
                planned = offer.plan is not None
                run = run_columns(search.problem, findings, suspects.every, offer.recording, planned)
                columns.append(run)
                usable.append(offer)
            except ExidynError as error:
                tell(f"{offer.name} is not available: {error}")
        belief = belief_of(search, suspects, columns, nameless_torque(diagnosis, search))
        moved = sum(recording.duration for recording in recordings)
        choice = choose(belief, usable, columns, self.seconds - moved, bool(diagnosis.remainders))
        chosen = choice.chosen
        saved = RoundChoice.of(
            belief,
            choice,
            diagnosis,
            gains,
            self.model,
            moved=moved,
            asked=self.options,
            shapes=shape_rows([*earlier_shapes, *shapes_of(search.selected)]),
            chosen=None if chosen is None else self.source.chosen(chosen.offer, part),
        )
        write_whole(part / CHOICE, json_text(saved.table))
