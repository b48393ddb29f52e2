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
from ..terminal.json_output import json_text, plain, write_whole
from ..terminal.stopwatch import with_bar
from .choice_file import choice_table, read_shapes, shape_table
from .choice_schema import require_course
from .notebook import notebook
from .other_gains import gain_sentences, other_gains, with_gains
from .rounds import CHOICE, NOTEBOOK, Round, fill_folder, next_round, rounds, tell
from .sources import Source

Identify = Callable[[Sequence[Path], Path], None]
Diagnose = Callable[[Case, Path], Diagnosed]


@dataclass(frozen=True)
class Study:
    """What a study is about, and how its steps are done.

    Attributes:
        folder: Where its files are.
        model: Nominal.
        source: Where its runs come from.
        seconds: Longest time in motion [s].
        identify: Makes the files of a fit from runs, as `exidyn identify` does.
        diagnose: Makes the files of a diagnosis, as `exidyn diagnose` does.
        asked: What was asked for, by name; a study that ended is continued where that has changed.
    """

    folder: Path
    model: Model
    source: Source
    seconds: float
    identify: Identify
    diagnose: Diagnose
    asked: dict[str, Any]

    def run(self) -> dict[str, Any]:
        """Until it is decided, undecidable or out of time; the last choice, as its table.

        Raises:
            RunStopped: A run was stopped before its end; the notebook says so too.
        """
        while True:
            one = next_round(self.folder)
            try:
                choice = self._complete(one)
            except RunStopped as stopped:
                self._write_notebook(str(stopped))
                raise
            self._write_notebook()
            if choice["verdict"] != RUN:
                return choice

    def _write_notebook(self, stopped: str = "") -> None:
        """The account so far, and why the last run ended before its time."""
        choices = [(one.name, choice) for one in rounds(self.folder) if (choice := one.choice) is not None]
        require_course(self.folder, choices)
        stops = [(one.name, why) for one in rounds(self.folder) for why in one.stops]
        write_whole(self.folder / NOTEBOOK, notebook(self.model.robot.name, choices, stopped, stops))

    def _complete(self, one: Round) -> dict[str, Any]:
        """All steps of a round of which there is no result yet, and its choice."""
        before = rounds(self.folder)[: one.number - 1]
        one.folder.mkdir(parents=True, exist_ok=True)
        if not one.run.exists():
            last = before[-1].choice if before else None
            what = "the first run" if last is None else last["offers"][0]["name"]
            print(f"{one.name}: {what}", file=sys.stderr)
            self.source.make(one, None if last is None else last["chosen"])
        every = [*before, one]
        fill_folder(one.fit, lambda part: self._fitted(every, part))
        fill_folder(one.diagnosis, lambda part: self._believed(every, part))
        choice = one.choice
        assert choice is not None
        return choice

    def _fitted(self, every: Sequence[Round], part: Path) -> None:
        """A fit of all runs; what runs cannot carry is no reason to end."""
        try:
            self.identify([one.run for one in every], part)
        except ExidynError as error:
            write_whole(part / "none.txt", f"{error}\n")
            tell(f"no fit: {error}")

    def _believed(self, every: Sequence[Round], part: Path) -> None:
        """Diagnosis, offers and choice."""
        recordings = distinct_bodies([one.recording() for one in every])
        last = every[-2].choice if len(every) > 1 else None
        before = read_shapes(last)
        file = every[-1].fit / "fit.json"
        fit = read_fit(file) if file.exists() else None
        gains = other_gains(fit, self.model)
        model = with_gains(self.model, gains)
        case = Case(model.robot.name, model, [("identify", one) for one in recordings], before)
        diagnosis, search = self.diagnose(case, part)
        offers = self.source.offers(every, diagnosis, fit)
        suspects, found = suspects_of(search), [one.answer for one in search.selected]
        usable: list[Offer] = []
        columns: list[RunColumns] = []
        tell("weighs what each run on offer would show")
        for offer in with_bar(offers):
            try:
                planned = offer.plan is not None
                run = run_columns(search.problem, found, suspects.every, offer.recording, planned)
                columns.append(run)
                usable.append(offer)
            except ExidynError as error:
                tell(f"{offer.name} is not on offer: {error}")
        belief = belief_of(search, suspects, columns, nameless_torque(diagnosis, search))
        moved = sum(one.duration for one in recordings)
        choice = choose(belief, usable, columns, self.seconds - moved, bool(diagnosis.remainders))
        table = choice_table(belief, choice, diagnosis) | {"moved": moved, "asked": self.asked}
        table["believed"] = [*gain_sentences(gains, self.model), *table["believed"]]
        table["findings"] = sorted([*table["findings"], *(["drive_gain", [one.joint + 1]] for one in gains)])
        table["shapes"] = shape_table([*before, *shapes_of(search.selected)])
        chosen = choice.chosen
        table["chosen"] = None if chosen is None else self.source.chosen(chosen.offer, part)
        write_whole(part / CHOICE, json_text(plain(table)))
