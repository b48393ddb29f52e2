"""Sources of the runs of a study: a cell that records them, or existing recordings."""

import hashlib
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import Protocol

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.errors import ExidynError, NotAFile
from exidyn.identification.fit.fit import Fit
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import import_source, kind_of
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.trajectories.next_run.offers import (
    EXCITATIONS,
    Offer,
    Planned,
    distinguishing,
    excitation,
    kinds_of_run,
    kinds_with_body,
    offers_of,
)
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import HASH_DIGITS, Plan
from exidyn.trajectories.plans.plan_file import plan_text, read_plan, write_plan

from ..files.given_runs import distinct_bodies
from ..run.before import check_plan
from ..run.recorder import part_of
from ..terminal.json_output import write_whole
from ..terminal.stopwatch import with_bar
from .choice_file import Chosen
from .rounds import CHOICE, NEXT, Round, ask, tell

NOT_RECORDINGS = ("", ".toml", ".md", ".txt", ".json", ".html")
"""Suffixes of files that may lie beside recordings."""


class Source(Protocol):
    """A cell that records runs, or existing recordings."""

    def make(self, current: Round, chosen: Chosen | None) -> None:
        """Write the recording of the current round: the chosen run, or the first run if None."""

    def offers(self, rounds_so_far: Sequence[Round], diagnosis: Diagnosis, fit: Fit | None) -> list[Offer]:
        """Runs that are available after these rounds."""

    def chosen(self, offer: Offer, folder: Path) -> Chosen:
        """What `make` needs to record a chosen offer; its files go into the folder."""


Record = Callable[[Path, Path, KnownPayload | None], None]
"""Plays the plan of a file with a payload and records it to a path; raises `RunStopped` if it is stopped
early."""


@dataclass(frozen=True)
class Cell:
    """A controller with its arm.

    Attributes:
        model: Nominal model.
        record: Function that plays and records a plan, as `exidyn record` does.
        wishes: Planning options of all optimized trajectories.
        search: Time for each trajectory optimization [s].
        payload: Payload that a person can attach to the flange, or None.
        attended: Whether a person must do what a run requests; not needed by a simulated arm.
        folder: Folder of the motions that do not depend on the open questions.
    """

    model: Model
    record: Record
    wishes: Wishes
    search: float
    payload: KnownPayload | None
    attended: bool
    folder: Path
    _checked: dict[tuple[str, KnownPayload | None], str] = field(default_factory=dict, repr=False)

    def make(self, current: Round, chosen: Chosen | None) -> None:
        """Plan the first motion or read the chosen one, ask a person for what it needs, and record it.

        Raises:
            RunStopped: If the run was stopped before its end.
        """
        if not current.plan.exists():
            study = current.folder.parent
            motion = None if chosen is None else read_plan(study / _required(chosen.plan, "plan"))
            write_plan(motion or excitation(self.model, self.wishes, None, 1, self.search)[1], current.plan)
        if chosen is not None and chosen.request and self.attended:
            ask(chosen.request)
        carried = self.payload if chosen is not None and chosen.loaded else None
        attempts = (current.folder / f"attempt-{number}.mcap" for number in count(1))
        attempt = next(path for path in attempts if not path.exists() and not part_of(path).exists())
        self.record(current.plan, attempt, carried)
        os.replace(attempt, current.run)

    def offers(self, rounds_so_far: Sequence[Round], diagnosis: Diagnosis, fit: Fit | None) -> list[Offer]:
        """Runs of every kind, an excitation planned from the fit, and one that distinguishes rivals."""
        tell("planning the runs that may come next")
        last = rounds_so_far[-1].recording()
        seed = len(rounds_so_far) + 1
        planned = [*self._kinds(), *self._single_joint(diagnosis), *self._optimized(diagnosis, fit, seed)]
        loaded = list(self._loaded(planned, fit, seed))
        warm, rate = "temperature" in last.signals, 1.0 / self.wishes.tick
        offers = offers_of(self.model, planned, loaded, self.payload, last.payload, rate, warm, with_bar)
        made = {(past.plan.read_text(encoding="utf-8"), past.recording().payload) for past in rounds_so_far}
        return [offer for offer in with_bar(offers) if self._is_available(offer, made)]

    def chosen(self, offer: Offer, folder: Path) -> Chosen:
        """The path of its motion, which is written to the folder, and what it requests of a person."""
        assert offer.plan is not None
        write_plan(offer.plan, folder / NEXT)
        place = Path(folder.parent.name) / folder.name.removesuffix(".part") / NEXT
        return Chosen(str(place), offer.payload is not None, offer.request)

    def _optimized(self, diagnosis: Diagnosis, fit: Fit | None, seed: int) -> list[Planned]:
        planned: list[Planned] = []
        for after in [None] if fit is None else [fit, None]:
            try:
                planned.append(excitation(self.model, self.wishes, after, seed, self.search))
                break
            except ExidynError as error:
                tell(f"no excitation: {error}")
        try:
            planned += distinguishing(self.model, diagnosis, self.wishes, seed, self.search)
        except ExidynError as error:
            tell(f"no motion that distinguishes rivals: {error}")
        return planned

    def _single_joint(self, diagnosis: Diagnosis) -> Iterator[Planned]:
        """Runs of each joint that has a finding; they are shorter than runs of all joints."""
        findings = [*diagnosis.findings, *diagnosis.undecided]
        for joint in sorted({finding.joints[0] for finding in findings if finding.joints}):
            folder = self.folder / f"joint {joint + 1}"
            if not folder.exists():
                _write_motions(folder, kinds_of_run(self.model, self.wishes, tell, joint))
            yield from _motions(folder)

    def _loaded(self, planned: Sequence[Planned], fit: Fit | None, seed: int) -> Iterator[Planned]:
        """The motions for an arm with the payload, replanned if they exceed a limit with it."""
        kinds = {name for name, _ in self._kinds()}
        for name, motion in planned if self.payload is not None else ():
            if not self._refusal(motion, self.payload):
                yield name, motion
            elif name in kinds:
                yield from self._kind_with_payload(name)
            elif name in EXCITATIONS:
                yield from self._excitation_with_payload(fit, seed)

    def _kind_with_payload(self, name: str) -> Iterator[Planned]:
        """A run of a kind with the payload, planned once and stored; the file is empty if there is none."""
        assert self.payload is not None
        digest = hashlib.sha256(repr(self.payload.known).encode()).hexdigest()[:HASH_DIGITS]
        path = self.folder / digest / f"{name}.toml"
        if not path.exists():
            tell(f"planning {name}, for an arm that carries the payload")
            path.parent.mkdir(exist_ok=True)
            plans = kinds_with_body(self.model, self.wishes, name.split()[-1])
            motion = next((plan for plan in plans if not self._refusal(plan, self.payload)), None)
            write_whole(path, "" if motion is None else plan_text(motion))
        if path.stat().st_size:
            yield name, read_plan(path)

    def _excitation_with_payload(self, fit: Fit | None, seed: int) -> Iterator[Planned]:
        for after in [None] if fit is None else [fit, None]:  # a fit without a payload plans without one
            try:
                yield excitation(self.model, self.wishes, after, seed, self.search, self.payload)
                return
            except ExidynError as error:
                reason = error
        tell(f"no excitation with the payload: {reason}")

    def _kinds(self) -> list[Planned]:
        """Runs of all kinds, planned once and stored in files by name."""
        if not self.folder.exists():
            _write_motions(self.folder, kinds_of_run(self.model, self.wishes, tell))
        return _motions(self.folder)

    def _is_available(self, offer: Offer, made: set[tuple[str, KnownPayload | None]]) -> bool:
        """Whether an offer differs from the runs already made, and `exidyn record` would play it."""
        assert offer.plan is not None
        if not offer.warm and (plan_text(offer.plan), offer.payload) in made:
            return False
        refusal = self._refusal(offer.plan, offer.payload)
        if refusal:
            tell(f"{offer.name} is not available: {refusal}")
        return not refusal

    def _refusal(self, motion: Plan, payload: KnownPayload | None) -> str:
        """Why `exidyn record` would not play a motion; each motion and payload is checked once."""
        key = plan_text(motion), payload
        if key not in self._checked:
            try:
                check_plan(motion, self.model, 1.0, payload)
                self._checked[key] = ""
            except ExidynError as error:
                self._checked[key] = str(error)
        return self._checked[key]


def _write_motions(folder: Path, planned: Iterable[Planned]) -> None:
    """Write one file per motion, to a folder that appears when it is complete."""
    part = folder.with_name(folder.name + ".part")
    part.mkdir(parents=True, exist_ok=True)
    for name, motion in planned:
        write_plan(motion, part / f"{name}.toml")
    os.replace(part, folder)


def _motions(folder: Path) -> list[Planned]:
    return [(path.stem, read_plan(path)) for path in sorted(folder.glob("*.toml"))]


@dataclass(frozen=True)
class Shelf:
    """Existing recordings.

    Attributes:
        recordings: Recordings with distinct names, sorted by name.
    """

    recordings: tuple[Recording, ...]

    @classmethod
    def of(cls, folder: Path, model: Model) -> "Shelf":
        """Read the recordings in a folder; raises `NotAFile` if there are none."""
        recordings: list[Recording] = []
        for path in sorted(folder.iterdir()) if folder.is_dir() else ():
            if path.suffix in NOT_RECORDINGS:
                continue
            try:
                kind_of(path)
                name = path.name.split(".")[0]
                recordings += [replace(recording, name=name) for recording in import_source(path, model)]
            except ExidynError as error:
                tell(f"{path} is skipped: {error}")
        if not recordings:
            raise NotAFile(f"--from {folder}: no recordings there")
        return cls(tuple(replace(recording, model=model) for recording in distinct_bodies(recordings)))

    def make(self, current: Round, chosen: Chosen | None) -> None:
        """Write the chosen recording; the first run is one without a payload, like the nominal model."""
        empty = [recording for recording in self.recordings if recording.payload is None]
        first = (empty or list(self.recordings))[0].name
        wanted = first if chosen is None else _required(chosen.recording, "recording")
        [recording] = [recording for recording in self.recordings if recording.name == wanted]
        part = current.run.with_name("run.part.mcap")
        write_recording(recording, part)
        os.replace(part, current.run)

    def offers(self, rounds_so_far: Sequence[Round], diagnosis: Diagnosis, fit: Fit | None) -> list[Offer]:
        """All recordings that are not used yet."""
        used = {past.recording().name for past in rounds_so_far}
        return [Offer(unused.name, unused) for unused in self.recordings if unused.name not in used]

    def chosen(self, offer: Offer, folder: Path) -> Chosen:
        """The name of the recording."""
        return Chosen(recording=offer.name)


def _required(name: str | None, kind: str) -> str:
    """The chosen plan or recording; raises `NotAFile` if the study was started with the other source."""
    if name is None:
        raise NotAFile(
            f"{CHOICE} has no {kind}: the study was started with another source of runs (--from or a "
            "controller). Start in another folder (--output)"
        )
    return name
