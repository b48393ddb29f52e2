"""Recordings that exist as the source of a study's runs."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from exidyn.identify.diagnosis import Diagnosis
from exidyn.identify.errors import ExidynError, NotAFile
from exidyn.identify.fit.fit import Fit
from exidyn.identify.model import Model
from exidyn.identify.recordings.importers import import_source, kind_of
from exidyn.identify.recordings.mcap.mcap_file import write_recording
from exidyn.identify.recordings.recording import Recording
from exidyn.trajectories.next_run.offers import Offer

from ..files.payload_runs import distinct_bodies
from .asking import tell
from .rounds import Round

NONE = ("", ".toml", ".md", ".txt", ".json", ".html")
"""Endings of files that lie beside recordings."""


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
        wanted = first if chosen is None else chosen["recording"]
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
