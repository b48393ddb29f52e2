"""Schema of the JSON file of a comparison: the types of its fields, and what has to agree between them."""

from msgspec import Struct

from exidyn.identify.schema import Name, Number, NumberOrNull, Size, check_length, check_rows
from exidyn.identify.simulation.comparison import THIRDS

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
