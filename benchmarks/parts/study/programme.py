"""Programmes: two or three runs that are the same for every arm, and the best of all of them."""

import os
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.trajectories.kinds.by_rule import KINDS as BY_RULE
from exidyn.trajectories.kinds.by_rule import by_rule
from exidyn.trajectories.next_run.offers import excitation
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import read_plan, write_plan

from .answer import Answer, of_runs
from .case import BODY, WISHES, Case

SEARCH = 1.0
"""For each motion that is searched [s]."""
SEARCHED = {
    "excitation": (1, 1.0),
    "second excitation": (2, 1.0),
    "short excitation": (3, 0.5),
}
"""Name -> seed, and length over that of an excitation."""
OTHER = "another motion"
"""On which parameters are judged."""
LONG = ("sweeps", "poses", "single-joint")
"""Three to ten times as long as any other: beside one other run, and not beside two."""


class Run(NamedTuple):
    """One run of a programme: its motion by name, and whether the body hangs on the flange."""

    motion: str
    loaded: bool

    @property
    def body(self) -> KnownPayload | None:
        return BODY if self.loaded else None

    @property
    def words(self) -> str:
        return f"{self.motion}, with the body" if self.loaded else self.motion


Programme = tuple[Run, ...]


def words(programme: Programme) -> str:
    """What people call it."""
    return "; ".join(run.words for run in programme)


def motions(folder: Path) -> dict[str, Plan]:
    """Every motion by its name, from a folder where they are kept; those by rule lie in its `by rule`."""
    model = Case.drawn("nothing", 0).nominal
    rules = folder / "by rule"
    rules.mkdir(parents=True, exist_ok=True)
    for kind in BY_RULE:
        if not (rules / f"a run of the kind {kind}.toml").exists():
            write_plan(by_rule(kind, model, WISHES), rules / f"a run of the kind {kind}.toml")
    for name, (seed, share) in (SEARCHED | {OTHER: (4, 1.0)}).items():
        if not (folder / f"{name}.toml").exists():
            wishes = type(WISHES)(**vars(WISHES) | {"seconds": share * WISHES.seconds})
            write_plan(excitation(model, wishes, None, seed, SEARCH)[1], folder / f"{name}.toml")
    found = {path.stem: read_plan(path) for path in folder.glob("*.toml")}
    return found | {path.stem.split()[-1]: read_plan(path) for path in rules.glob("*.toml")}


def programmes() -> Iterator[Programme]:
    """All of two or three runs, each with and without the body; long ones beside one other run."""
    every = [Run(name, loaded) for name in (*SEARCHED, "chirp") for loaded in (False, True)]
    slow = [Run(name, loaded) for name in LONG for loaded in (False, True)]
    for count in (2, 3):
        yield from combinations(every, count)
    yield from ((run, one) for run in every[:2] for one in slow)


def answered(case: Case, programme: Programme, folder: Path) -> Answer:
    """What a programme says of an arm; the body is hung on once, behind the runs without it."""
    runs = [recorded(case, run, folder) for run in sorted(programme, key=lambda run: run.loaded)]
    hands = int(any(run.loaded for run in programme))
    return of_runs(case, runs, motions(folder)[OTHER], hands)


def recorded(case: Case, run: Run, folder: Path) -> Recording:
    """A run of an arm, made once; the arm makes it as often as programmes have it."""
    path = folder / f"{case.kind}, {case.seed}" / f"{run.words}.mcap"
    if not path.exists():
        path.parent.mkdir(exist_ok=True)
        part = path.with_suffix(f".{os.getpid()}.mcap")
        write_recording(case.run(motions(folder)[run.motion], run.body, run.words), part)
        os.replace(part, path)
    return replace(read_recording(path), name=run.words)
