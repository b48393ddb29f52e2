"""Sources of the runs of a study: a cell that makes them, or recordings that exist."""

import hashlib
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import Any, Protocol

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.errors import ExidynError, NotAFile
from exidyn.identification.fit.fit import Fit
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import import_source, kind_of
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.trajectories.next_run.offers import (
    EXCITATIONS,
    WARM_UP,
    Offer,
    Planned,
    distinguishing,
    excitation,
    kinds_of_joint,
    kinds_of_run,
    kinds_with_body,
    offers_of,
)
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import HASH_DIGITS, Plan
from exidyn.trajectories.plans.plan_file import plan_text, read_plan, write_plan

from ..files.given_runs import distinct_bodies
from ..run.before import checked
from ..run.recorder import part_of
from ..terminal.json_output import write_whole
from ..terminal.stopwatch import with_bar
from .rounds import CHOICE, NEXT, Round, ask, tell

NONE = ("", ".toml", ".md", ".txt", ".json", ".html")
"""Endings of files that lie beside recordings."""


class Source(Protocol):
    """A cell that makes runs, or recordings that exist."""

    def make(self, one: Round, chosen: dict[str, Any] | None) -> None:
        """Put the run of a round under its name, by what was chosen; None for the first."""

    def offers(self, every: Sequence[Round], diagnosis: Diagnosis, fit: Fit | None) -> list[Offer]:
        """What could be run behind these rounds."""

    def chosen(self, offer: Offer, folder: Path) -> dict[str, Any]:
        """What `make` needs of an offer that was chosen; files go into the folder."""


Record = Callable[[Path, Path, KnownPayload | None], None]
"""Plays the plan of a file and records it under a path, with what hangs on the flange; raises `RunStopped`
where it does not come to its end."""


@dataclass(frozen=True)
class Cell:
    """A controller with its arm.

    Attributes:
        model: Nominal.
        record: Plays and records, as `exidyn record`.
        wishes: What every motion that is searched is to be.
        search: For each search [s].
        body: What a person has to hang on the flange; None for nothing.
        attended: Whether a person has to do what a run asks; a simulated arm needs none.
        folder: For motions that do not depend on what is open.
    """

    model: Model
    record: Record
    wishes: Wishes
    search: float
    body: KnownPayload | None
    attended: bool
    folder: Path
    _checked: dict[tuple[str, KnownPayload | None], str] = field(default_factory=dict, repr=False)

    def make(self, one: Round, chosen: dict[str, Any] | None) -> None:
        """Plan or take the motion that was chosen, ask for what it needs, and record it.

        Raises:
            RunStopped: It was stopped before its end.
        """
        if not one.plan.exists():
            motion = None if chosen is None else read_plan(one.folder.parent / _required(chosen, "plan"))
            write_plan(motion or excitation(self.model, self.wishes, None, 1, self.search)[1], one.plan)
        if chosen is not None and chosen["request"] and self.attended:
            ask(chosen["request"])
        carried = self.body if chosen is not None and chosen["loaded"] else None
        attempts = (one.folder / f"attempt-{number}.mcap" for number in count(1))
        attempt = next(path for path in attempts if not path.exists() and not part_of(path).exists())
        self.record(one.plan, attempt, carried)
        os.replace(attempt, one.run)

    def offers(self, every: Sequence[Round], diagnosis: Diagnosis, fit: Fit | None) -> list[Offer]:
        """Runs of every kind, an excitation after the fit, and one that distinguishes what is open."""
        tell("plans the runs that may come next")
        last = every[-1].recording()
        seed = len(every) + 1
        planned = [*self._kinds(), *self._of_joints(diagnosis), *self._searched(diagnosis, fit, seed)]
        loaded = list(self._loaded(planned, fit, seed))
        warm, rate = "temperature" in last.signals, 1.0 / self.wishes.tick
        offers = offers_of(self.model, planned, loaded, self.body, last.payload, rate, warm, with_bar)
        made = {(one.plan.read_text(encoding="utf-8"), one.recording().payload) for one in every}
        return [one for one in with_bar(offers) if _new(one, made) and self._allowed(one)]

    def chosen(self, offer: Offer, folder: Path) -> dict[str, Any]:
        """Its motion, as a file, and what it asks."""
        assert offer.plan is not None
        write_plan(offer.plan, folder / NEXT)
        place = Path(folder.parent.name) / folder.name.removesuffix(".part") / NEXT
        return {"plan": str(place), "loaded": offer.payload is not None, "request": offer.request}

    def _searched(self, diagnosis: Diagnosis, fit: Fit | None, seed: int) -> list[Planned]:
        found: list[Planned] = []
        for after in [None] if fit is None else [fit, None]:
            try:
                found.append(excitation(self.model, self.wishes, after, seed, self.search))
                break
            except ExidynError as error:
                tell(f"no excitation: {error}")
        try:
            found += distinguishing(self.model, diagnosis, self.wishes, seed, self.search)
        except ExidynError as error:
            tell(f"no motion against a rival: {error}")
        return found

    def _of_joints(self, diagnosis: Diagnosis) -> Iterator[Planned]:
        """Runs of single joints on which something was found: shorter than those of all of them."""
        every = [*diagnosis.findings, *diagnosis.undecided]
        for joint in sorted({one.joints[0] for one in every if one.joints}):
            folder = self.folder / f"joint {joint + 1}"
            if not folder.exists():
                _write_motions(folder, kinds_of_joint(self.model, self.wishes, joint, tell))
            yield from _motions(folder)

    def _loaded(self, planned: Sequence[Planned], fit: Fit | None, seed: int) -> Iterator[Planned]:
        """The same motions for an arm that carries the body, planned anew where that asks for too much."""
        kinds = {name for name, _ in self._kinds()}
        for name, motion in planned if self.body is not None else ():
            if not self._refusal(motion, self.body):
                yield name, motion
            elif name in kinds:
                yield from self._kind_with_body(name)
            elif name in EXCITATIONS:
                yield from self._excitation_with_body(fit, seed)

    def _kind_with_body(self, name: str) -> Iterator[Planned]:
        """Made once, and kept in a file of its body; none where that is empty."""
        assert self.body is not None
        body = hashlib.sha256(repr(self.body.known).encode()).hexdigest()[:HASH_DIGITS]
        path = self.folder / body / f"{name}.toml"
        if not path.exists():
            tell(f"{name} is planned for an arm that carries the body")
            path.parent.mkdir(exist_ok=True)
            made = kinds_with_body(self.model, self.wishes, name.split()[-1])
            motion = next((one for one in made if not self._refusal(one, self.body)), None)
            write_whole(path, "" if motion is None else plan_text(motion))
        if path.stat().st_size:
            yield name, read_plan(path)

    def _excitation_with_body(self, fit: Fit | None, seed: int) -> Iterator[Planned]:
        for after in [None] if fit is None else [fit, None]:  # a fit without a payload plans for none
            try:
                yield excitation(self.model, self.wishes, after, seed, self.search, self.body)
                return
            except ExidynError as error:
                why = error
        tell(f"no excitation with the body: {why}")

    def _kinds(self) -> list[Planned]:
        """Made once; names and motions are kept in files."""
        if not self.folder.exists():
            _write_motions(self.folder, kinds_of_run(self.model, self.wishes, tell))
        return _motions(self.folder)

    def _allowed(self, offer: Offer) -> bool:
        """Whether `exidyn record` would play it."""
        assert offer.plan is not None
        refusal = self._refusal(offer.plan, offer.payload)
        if refusal:
            tell(f"{offer.name} is not on offer: {refusal}")
        return not refusal

    def _refusal(self, motion: Plan, payload: KnownPayload | None) -> str:
        """Why `exidyn record` would not play a motion; a motion with a body is checked once."""
        key = plan_text(motion), payload
        if key not in self._checked:
            self._checked[key] = _why_not(motion, self.model, payload)
        return self._checked[key]


def _write_motions(folder: Path, planned: Iterable[Planned]) -> None:
    """A file each, in a folder that appears when it is whole."""
    part = folder.with_name(folder.name + ".part")
    part.mkdir(parents=True, exist_ok=True)
    for name, motion in planned:
        write_plan(motion, part / f"{name}.toml")
    os.replace(part, folder)


def _motions(folder: Path) -> list[Planned]:
    return [(path.stem, read_plan(path)) for path in sorted(folder.glob("*.toml"))]


def _why_not(motion: Plan, model: Model, payload: KnownPayload | None) -> str:
    """Why `exidyn record` would not play a motion; empty where it would."""
    try:
        checked(motion, model, 1.0, payload)
    except ExidynError as error:
        return str(error)
    return ""


def _new(offer: Offer, made: set[tuple[str, KnownPayload | None]]) -> bool:
    assert offer.plan is not None
    return offer.request == WARM_UP or (plan_text(offer.plan), offer.payload) not in made


@dataclass(frozen=True)
class Shelf:
    """Recordings that exist.

    Attributes:
        recordings: In the order of their names, each with a name of its own.
    """

    recordings: tuple[Recording, ...]

    @classmethod
    def of(cls, folder: Path, model: Model) -> "Shelf":
        """Those in a folder.

        Raises:
            NotAFile: There are none.
        """
        found = []
        for path in sorted(folder.iterdir()) if folder.is_dir() else ():
            if path.suffix in NONE:
                continue
            try:
                kind_of(path)
                found += [replace(one, name=path.name.split(".")[0]) for one in import_source(path, model)]
            except ExidynError as error:
                tell(f"{path} is left out: {error}")
        if not found:
            raise NotAFile(f"--from {folder}: no recordings there")
        return cls(tuple(replace(one, model=model) for one in distinct_bodies(found)))

    def make(self, one: Round, chosen: dict[str, Any] | None) -> None:
        """The first begins without a body, as the nominal model is."""
        empty = [recording for recording in self.recordings if recording.payload is None]
        first = (empty or list(self.recordings))[0].name
        wanted = first if chosen is None else _required(chosen, "recording")
        [recording] = [recording for recording in self.recordings if recording.name == wanted]
        part = one.run.with_name("run.part.mcap")
        write_recording(recording, part)
        os.replace(part, one.run)

    def offers(self, every: Sequence[Round], diagnosis: Diagnosis, fit: Fit | None) -> list[Offer]:
        """All that were not taken yet."""
        taken = {one.recording().name for one in every}
        return [Offer(one.name, one) for one in self.recordings if one.name not in taken]

    def chosen(self, offer: Offer, folder: Path) -> dict[str, Any]:
        """Its name."""
        return {"recording": offer.name}


def _required(chosen: dict[str, Any], key: str) -> str:
    """What was chosen.

    Raises:
        NotAFile: The study was begun with runs of the other kind.
    """
    if chosen.get(key) is None:
        raise NotAFile(
            f"{CHOICE} has chosen no {key}: the study was begun otherwise. Begin in another folder"
        )
    return str(chosen[key])
