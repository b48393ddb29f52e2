"""Time of the rows of a table: its column and unit, or a rate if the file has no time."""

from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from ...errors import NotAFile, NotFinite, RecordingError
from ..units import factors, unit_named
from .columns import Columns, Names, own_time
from .preset import Preset, Reading
from .table import DATE, Table

YEARS = (datetime(2000, 1, 1, tzinfo=UTC).timestamp(), datetime(2100, 1, 1, tzinfo=UTC).timestamp())
"""Range of a robot's clock [s since 1970]."""
RATES = (5.0, 2e4)
"""Range of the sampling rate of a log [Hz]; with `YEARS` it leaves one possible unit of a time stamp."""
SINCE_1970 = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def with_rate(preset: Preset, columns: Columns, chosen: Mapping[str, Names], rate: float) -> Preset:
    """Preset for a file without time, with its sampling rate [Hz].

    Raises:
        RecordingError: The file has a time column.
    """
    stated = str(chosen.get("time") or preset.signals.get("time", Reading("")).column)
    column = stated if chosen.get("time") or stated in columns.table.names else own_time(columns.table)
    require_no_time(columns.source, column)
    others = {signal: reading for signal, reading in preset.signals.items() if signal != "time"}
    return replace(preset, signals=others, rate=rate)


def require_no_time(source: Path, column: str) -> None:
    """Refuse a rate for a file with a time column; `column` is "" if it has none.

    Raises:
        RecordingError: There is a time column.
    """
    if column:
        raise RecordingError(
            f"{source} has its own time, column {column}; --rate (rate) is for tables and arrays without time"
        )


def stamped(
    columns: Columns, preset: Preset, place: int | None, scale: float | None
) -> tuple[Table, np.ndarray, list[str]]:
    """Rows of a table that have a time, their time stamps (t,) [s], and sentences about their reading.

    Args:
        columns: Columns of the table.
        preset: Preset of the table.
        place: Index of the time column; None if the preset has a rate.
        scale: Seconds per unit of the time column, which overrides a stated unit; None for the stated unit.

    Raises:
        NotAFile: There are fewer than two rows.
        NotFinite: Fewer than two rows have a time.
    """
    source, table = columns.source, columns.table
    if len(table.values) < 2:
        raise NotAFile(f"{source} has one sample, in {table.place(0)}; a run has many")
    if place is None:
        return table, np.arange(len(table.values)) / preset.rate, []
    reading = preset.signals.get("time", Reading(""))
    times, name = table.values[:, place], table.names[place]
    known = np.isfinite(times)
    if known.sum() < 2:
        raise NotFinite(
            f"{source} {table.place(int(np.argmin(known)))}: no time stamp in column {name}, as in "
            f"{np.sum(~known)} of {len(known)} rows"
        )
    facts = []
    if not known.all():
        first = table.place(int(np.argmin(known)))
        facts.append(f"{np.sum(~known)} of {len(known)} rows have no time, first {first}; they are left out")
        table, times = table.rows(known), times[known]
    preset_unit = reading.unit if isinstance(reading.unit, str) else reading.unit[0]
    stated = preset_unit or table.unit(name)
    if table.units.get(name) == DATE:
        scale = 1.0
    elif scale is None and not stated and (unit := unit_since_1970(times)):
        scale = SINCE_1970[unit]
        date = datetime.fromtimestamp(times[0] * scale, UTC).isoformat(sep=" ", timespec="seconds")
        facts.append(f"time: {name} is read as {unit} since 1970, the first as {date} (UTC)")
    if scale is None:
        entry = unit_named(stated or "s")
        of_another = not preset_unit and (entry is None or entry[0] != "s")
        scale = float(factors(["s"], "" if of_another else stated, f"{preset.name or source}: time")[0][0])
    return table, reading.numbers(times[:, None], f"{preset.name}: time")[:, 0] * scale, facts


def unit_since_1970(times: np.ndarray) -> str:
    """Unit of stamps (t,) since 1970, from the year and the rate; "" if it is s or unknown."""
    period = float(np.median(np.diff(times)))
    for unit, scale in SINCE_1970.items():
        if YEARS[0] < times[0] * scale < YEARS[1] and 1 / RATES[1] < period * scale < 1 / RATES[0]:
            return unit
    return ""
