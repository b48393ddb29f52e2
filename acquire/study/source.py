"""Source: where the runs of a study come from."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

from exidyn.identify.diagnosis import Diagnosis
from exidyn.identify.fit.fit import Fit
from exidyn.trajectories.next_run.offers import Offer

from .rounds import Round


class Source(Protocol):
    """A cell that makes runs, or recordings that exist."""

    def make(self, one: Round, chosen: dict[str, Any] | None) -> None:
        """Put the run of a round under its name, by what was chosen; None for the first."""

    def offers(self, every: Sequence[Round], diagnosis: Diagnosis, fit: Fit | None) -> list[Offer]:
        """What could be run behind these rounds."""

    def chosen(self, offer: Offer, folder: Path) -> dict[str, Any]:
        """What `make` needs of an offer that was chosen; files go into the folder."""
