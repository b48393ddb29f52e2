"""Schemas of a fleet's store: types of arms, runs, and changes."""

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta, Struct

from exidyn.identification.errors import ExidynError, NotAFile
from exidyn.identification.fit.fit_schema import Measures
from exidyn.identification.fleet.kind import Kind
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.schema import (
    Count,
    Name,
    Number,
    Positive,
    Size,
    check,
    check_length,
)

EARLIEST, LATEST = datetime(1970, 1, 1, tzinfo=UTC), datetime(2262, 1, 1, tzinfo=UTC)
"""Dates that a recording can have: its clock counts nanoseconds since 1970 in 63 bits."""
Text = Annotated[str, Meta(max_length=100_000)]
Noise = Annotated[float, Meta(ge=1e-30, le=1e18)]
"""Standard deviation [A or N m]. The rounding error of 1e15, the largest number of a recording, exceeds the
lower bound, and rows of such numbers divided by it have finite squares."""
Factor = Annotated[float, Meta(ge=-1e18, le=1e18)]
"""Root of the sum of squares of a million numbers of a recording, each at most 1e15."""
MaybeNumber = Number | None
"""A number, or None if it was not measured."""


class KindFile(Struct, frozen=True):
    """A type of arm, a file in `kinds/`; its filters are completely specified."""

    robot: str
    filtering: Filtering
    measures: Measures

    def __post_init__(self) -> None:
        half = 0.5 * (self.filtering.rate or 0.0)
        check(half > 0.0, "filtering.rate", self.filtering.rate, "a sampling rate")
        for name in ("position_cutoff", "torque_cutoff"):
            cutoff = getattr(self.filtering, name)
            check(cutoff is not None, f"filtering.{name}", cutoff, "a frequency")
            check(cutoff < half, f"filtering.{name}", cutoff, f"less than {half:g}, half the rate")


class IndexRow(Struct, frozen=True):
    """A run without its summary."""

    key: Name
    date: datetime
    kind: Text
    file: Text
    size: Count
    modified: Size
    error: Text
    note: Text
    arm: Name

    def __post_init__(self) -> None:
        aware = self.date.tzinfo is not None
        check(aware and EARLIEST <= self.date < LATEST, "date", self.date, "a date in UTC from 1970 to 2261")
        check("/" not in self.key and ".." not in self.key, "key", self.key, "the name of a file")
        for name in ("key", "file", "arm"):
            check("\0" not in getattr(self, name), name, getattr(self, name), "no character of code 0")


class RunRow(IndexRow, frozen=True):
    """An identified run."""

    seconds: Positive
    payload: Text
    payload_known: bool
    temperature: list[MaybeNumber]
    residual: list[Size]
    noise: list[Noise]
    counts: list[Count]
    factors: list[Factor]

    def __post_init__(self) -> None:
        super().__post_init__()
        joints = len(self.counts)
        check(joints > 0, "counts", self.counts, "a number for each joint")
        for name in ("temperature", "residual", "noise"):
            check_length(getattr(self, name), name, joints, "one per joint")


class ChangeRow(Struct, frozen=True):
    """A change of an arm; only arm and date are read."""

    arm: Name
    date: datetime


def require_kind(row: RunRow, kind: Kind) -> None:
    """Raise `Disagreement` unless a run's summary has the shapes of a type of arm."""
    joints, width = kind.model.robot.dof, len(kind.base.names) + 2
    check_length(row.counts, "counts", joints, "one per joint")
    check_length(
        row.factors, "factors", joints * width * (width + 1) // 2, f"{joints} triangles of {width} rows"
    )


@contextmanager
def refused(path: Path) -> Iterator[None]:
    """Raise any error in a file of a store as `NotAFile`, with what to do."""
    try:
        yield
    except MemoryError:
        raise
    except Exception as error:  # pyarrow's many types for damaged files, and `Disagreement`
        if isinstance(error, ExidynError) and not isinstance(error, NotAFile):
            raise
        text = str(error).removeprefix(f"{path}: ")
        raise NotAFile(
            f"{path}: {text}. Remove that file; exidyn fleet then recreates it from its recordings"
        ) from error


def plain(value: Any) -> Any:
    """A value of a Parquet file for the schema: NaN, which stands for not measured, becomes None."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and value != value else value
