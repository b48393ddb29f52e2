"""Cases: what is concealed in each, and what study and fixed programme make of it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.acquire.commands.study_command import diagnose_step, identify_step
from exidyn.acquire.run.simulated import simulated
from exidyn.acquire.study.loop import Study
from exidyn.acquire.study.rounds import rounds
from exidyn.acquire.study.sources import Cell
from exidyn.identify.diagnosis import diagnose
from exidyn.identify.effects import Payload, known_parameters
from exidyn.identify.recordings.mcap.mcap_file import write_recording
from exidyn.identify.recordings.recording import KnownPayload
from exidyn.trajectories.kinds.by_rule import by_rule
from exidyn.trajectories.next_run.offers import excitation
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import read_plan

from .arms import EFFECTS, Concealed, concealed, nominal, truth

BODY = KnownPayload("L", known_parameters(3.0, (0.05, 0.0, 0.02), (0.02, 0.0, 0.0, 0.02, 0.0, 0.02)))
WISHES = Wishes(seconds=16.0, tick=0.004)
SEARCH = 1.0
"""For each motion [s]."""
MINUTES, QUICK = 5.0, 0.8
"""Of motion, at most; the quick form has time for two runs."""


Named = frozenset[tuple[str, tuple[int, ...]]]
"""Effects, each with its joints from 1."""


@dataclass(frozen=True)
class Result:
    """One case: what was concealed and what was found, and minutes of motion.

    Attributes:
        concealed: In the arm.
        found: By the study.
        fixed: By the fixed programme.
        minutes: Of the study.
        fixed_minutes: Of the fixed programme.
        verdict: Of the study.
        proposed: Of each run that was chosen for what was open, whether it gave half of what was expected.
    """

    concealed: Named
    found: Named
    fixed: Named
    minutes: float
    fixed_minutes: float
    verdict: str
    proposed: Sequence[bool]

    @classmethod
    def read(cls, line: dict[str, Any]) -> "Result":
        """From a table of plain values."""
        return cls(**line | {key: named(line[key]) for key in ("concealed", "found", "fixed")})


def named(every: Iterable[tuple[str, Iterable[int]]]) -> Named:
    """Effects and joints."""
    return frozenset((effect, tuple(joints)) for effect, joints in every)


def drawn(seed: int, count: int) -> tuple[Concealed, ...]:
    """So many effects, of random kinds, joints and sizes."""
    random = np.random.default_rng(seed)
    names = random.choice(EFFECTS, count, replace=False)
    return tuple(
        concealed(str(name), int(random.integers(2)), float(random.uniform(0.7, 1.5))) for name in names
    )


def record(
    parts: tuple[Concealed, ...], seed: int, plan: Path, path: Path, body: KnownPayload | None
) -> None:
    """A run of the true arm, as fast as it computes."""
    write_recording(run(parts, read_plan(plan), body, seed, path.parent.name), path)


def run(parts: tuple[Concealed, ...], plan: Plan, body: KnownPayload | None, seed: int, name: str) -> Any:
    """The same, not written; without second encoders, which would measure the gears."""
    model, gears = truth(parts)
    loaded = model if body is None else model + Payload(body.name, body.known)
    recording = simulated(model, plan, loaded, body, gears, tick=WISHES.tick, seed=seed, name=name)
    signals = {name: one for name, one in recording.signals.items() if name != "link_position"}
    return replace(recording, model=nominal(), signals=signals)


def studied(parts: tuple[Concealed, ...], seed: int, folder: Path, minutes: float = MINUTES) -> Result:
    """Both programmes on one arm."""
    recorder = partial(record, parts, seed)
    cell = Cell(nominal(), recorder, WISHES, SEARCH, BODY, False, folder / "offers")
    study = Study(folder, nominal(), cell, 60.0 * minutes, identify_step, diagnose_step, {})
    choice = study.run()
    found = named(choice["findings"])
    fixed, needed = programme(parts, seed)
    there = named((part.name, (part.joint + 1,)) for part in parts)
    choices = [one.choice for one in rounds(folder)]
    return Result(there, found, fixed, choice["moved"] / 60.0, needed, choice["verdict"], settled(choices))


def settled(choices: Sequence[Any]) -> list[bool]:
    """Of each run that was chosen for what was open: whether it gave half of what was expected."""
    pairs = [(one, after) for one, after in zip(choices[:-1], choices[1:], strict=True) if _open(one)]
    return [one["entropy"] - after["entropy"] > 0.5 * one["offers"][0]["expected"] for one, after in pairs]


def _open(choice: Any) -> bool:
    return any(item["open"] for item in choice["items"])


def programme(parts: tuple[Concealed, ...], seed: int) -> tuple[Named, float]:
    """The fixed programme: identify, slow, payload, chirp."""
    model = nominal()
    first = excitation(model, WISHES, None, 1, SEARCH)[1]
    plans = [
        (first, None),
        (by_rule("sweeps", model, WISHES), None),
        (first, BODY),
        (by_rule("chirp", model, WISHES), None),
    ]
    runs = [run(parts, plan, body, seed, f"run{k}") for k, (plan, body) in enumerate(plans)]
    found = diagnose(model, [("identify", one) for one in runs])
    names = ((one.effect, (joint + 1 for joint in one.joints)) for one in found.findings)
    return named(names), sum(one.duration for one in runs) / 60.0
