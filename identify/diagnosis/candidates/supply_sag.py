"""Supply sag: a voltage that gives way, so that all drives need more current while the arm draws power."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ...model import Model
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..findings.quantities import Formatted
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts.rare import rare


def sags(model: Model) -> Iterator[Candidate]:
    """One of all drives."""

    def columns(run: Driven) -> np.ndarray:
        power = np.sum(np.maximum(run.torque * run.motion.velocity, 0.0), axis=1)
        return (run.torque * power[:, None])[:, :, None]

    yield rare(Candidate("supply_sag", (), columns, ("sag",), ("1/W",), (0.0,)))


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """In per cent a kilowatt."""
    if "sag" not in known:
        return {}
    return {"droop": Formatted(1e5 * known["sag"].value, 1e5 * known["sag"].std, "% per kW")}


KIND = Kind(
    sentence="The supply voltage sags: all drives need more current the more power the arm draws[, by "
    "{droop}]",
    drawn_against=("torque", "speed"),
    ask=sags,
    derived=_derived,
)
