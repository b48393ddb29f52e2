"""Studies of the same arms."""

import shutil
from pathlib import Path

from exidyn.acquire.commands.study_command import diagnose_step, identify_step
from exidyn.acquire.files.given_runs import Case as Diagnosable
from exidyn.acquire.files.given_runs import distinct_bodies
from exidyn.acquire.study.loop import Study
from exidyn.acquire.study.rounds import Round, rounds
from exidyn.acquire.study.sources import Cell
from exidyn.identification.diagnosis.diagnose import Diagnosed
from exidyn.trajectories.next_run.choice import DECIDED

from .answer import Answer, error_of
from .case import BODY, SHORT, Case, named
from .programme import OTHER, SEARCH, motions

MINUTES, QUICK = 5.0, 0.8
"""Of motion, at most; the quick form has time for two runs."""


def studied(case: Case, folder: Path, shared: Path, minutes: float = MINUTES) -> Answer:
    """What a study says of an arm; its motions by rule are those of the programmes."""
    plans, last = motions(shared), list[Diagnosed]()
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "offers").exists():
        shutil.copytree(shared / "by rule", folder / "offers")

    def diagnose(asked: Diagnosable, part: Path) -> Diagnosed:
        last[:] = [diagnose_step(asked, part)]
        return last[0]

    cell = Cell(case.nominal, case.record, SHORT, SEARCH, BODY, False, folder / "offers")
    study = Study(folder, case.nominal, cell, 60.0 * minutes, identify_step, diagnose, {})
    choice, every = study.run(), rounds(folder)
    runs = distinct_bodies([one.recording() for one in every])
    error = error_of(case, last[0], runs, plans[OTHER])
    found, hands = named(choice.findings), sum(_asked(one) for one in every[:-1])
    decided = choice.verdict == DECIDED
    return Answer(found, named(choice.possible), error, choice.moved, decided, hands)


def _asked(one: Round) -> bool:
    """Whether a person had something to do for the run behind a round."""
    choice = one.choice
    return bool(choice and choice.chosen and choice.chosen.request)
