"""Schema of the JSON file of a comparison: the types of its fields, and what has to agree between them."""

from typing import Any

from msgspec import Struct

from exidyn.identify.pages.compared_document import verdict
from exidyn.identify.schema import Name, Number, NumberOrNull, Size, check_length, check_rows
from exidyn.identify.simulation.comparison import THIRDS, Comparison, Mismatch

BY_JOINT = ("rms", "mean", "size", "noise")
"""A number a joint."""
Row = tuple[NumberOrNull, ...]


class RegionsTable(Struct, frozen=True):
    """Mismatch in thirds of what the arm did."""

    edges: tuple[Row, ...]
    rms: tuple[Row, ...]


class MismatchTable(Struct, frozen=True):
    """How far two recordings differ in one quantity."""

    units: tuple[str, ...]
    rms: Row
    mean: Row
    size: Row
    noise: Row
    regions: dict[str, RegionsTable]


class ComparisonFile(Struct, frozen=True, kw_only=True):
    """A comparison."""

    simulated: str
    recorded: str
    joints: tuple[Name, ...]
    offset: Number
    duration: Size
    filter_hz: Size
    mismatch: dict[Name, MismatchTable]
    verdict: tuple[str, ...]

    def __post_init__(self) -> None:
        for quantity, one in self.mismatch.items():
            for name in ("units", *BY_JOINT):
                self._by_joint(getattr(one, name), f"mismatch.{quantity}.{name}")
            for kind, regions in one.regions.items():
                where = f"mismatch.{quantity}.regions.{kind}"
                for name, count in (("edges", THIRDS + 1), ("rms", THIRDS)):
                    rows = getattr(regions, name)
                    self._by_joint(rows, f"{where}.{name}")
                    check_rows(rows, f"{where}.{name}", count, f"of {THIRDS} regions")

    def _by_joint(self, values: tuple, field: str) -> None:
        check_length(values, field, len(self.joints), "one a joint")


def comparison_table(comparison: Comparison, go_on: list[str]) -> dict[str, Any]:
    """The same in numbers, for JSON, with the commands that go on from here."""
    return {
        "exidyn_comparison": 1,
        "simulated": comparison.simulated,
        "recorded": comparison.recorded,
        "joints": list(comparison.joints),
        "offset": comparison.offset,
        "duration": comparison.duration,
        "filter_hz": comparison.cutoff,
        "mismatch": {one.quantity: _numbers(one) for one in comparison.mismatches},
        "verdict": verdict(comparison),
        "go_on": go_on,
    }


def _numbers(mismatch: Mismatch) -> dict[str, Any]:
    return {
        "units": list(mismatch.units),
        **{name: getattr(mismatch, name) for name in ("rms", "mean", "size", "noise")},
        "regions": {kind: regions._asdict() for kind, regions in mismatch.regions.items()},
    }
