"""Times and signals of a table in SI units, as stated with the import, by its preset, or by the file."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from ...errors import BadUnit, NotAFile, NotFinite, RecordingError, WrongShape
from ..misread_columns import percent_questions
from ..recording import SIGNALS, Signal
from ..units import ANGLES, COMMANDS, factors, is_travel, unit_named
from .columns import Columns, Names, own_time
from .preset import Preset, Reading
from .table import DATE, Table

Units = Mapping[str, str | Sequence[str]]
YEARS = (datetime(2000, 1, 1, tzinfo=UTC).timestamp(), datetime(2100, 1, 1, tzinfo=UTC).timestamp())
"""Range of a robot's clock [s since 1970]."""
RATES = (5.0, 2e4)
"""Range of the sampling rate of a log [Hz]; with `YEARS` it leaves one possible unit of a time stamp."""
SINCE_1970 = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}


class SignalUnits:
    """Signals of a table in the units of `SIGNALS`.

    The unit of a column is the first that is stated: with the import, by `degrees`, by the preset, by the
    file; for a command, by the measured signal. Otherwise it is the SI unit.
    """

    def __init__(
        self,
        columns: Columns,
        preset: Preset,
        places: Mapping[str, Sequence[int]],
        stated: Units,
        degrees: bool,
    ) -> None:
        self.facts: list[str] = []  # sentences about units in the file that were not applied
        self._columns, self._preset, self._places = columns, preset, places
        self._stated, self._degrees = stated, degrees
        if missing := [signal for signal in stated if signal not in places]:
            raise WrongShape(
                f"units (--units): {columns.source} has no {', '.join(missing)}; it has {', '.join(places)}"
            )

    def signals(self, time: np.ndarray, table_values: np.ndarray) -> dict[str, Signal]:
        """All signals, with times (t,) [s], from the values of a table (t, c)."""
        return {signal: Signal(time, self.values(signal, table_values)) for signal in self._places}

    def values(self, signal: str, table_values: np.ndarray) -> np.ndarray:
        """A signal in SI units (t, n), from the values of a table (t, c); NaN for joints without a column."""
        places, where = self._places[signal], self._where(signal)
        picked = table_values[:, [max(place, 0) for place in places]]
        picked[:, [place < 0 for place in places]] = np.nan
        picked[~np.isfinite(picked)] = np.nan
        robot = self._columns.robot
        factor, offset = factors(robot.units(SIGNALS[signal]), self.units(signal), where, robot.limits)
        return self._reading(signal).numbers(picked, where) * factor + offset

    def units(self, signal: str) -> list[str]:
        """Unit of the column of each joint; "" for SI."""
        si = self._columns.robot.units(SIGNALS[signal])
        options = self._each(self._stated.get(signal, ""), len(si), "units (--units)")
        preset = self._each(self._from_preset(signal).unit, len(si), self._where(signal))
        degrees = ["deg" + wanted[3:] if self._degrees and wanted in ANGLES else "" for wanted in si]
        measured = COMMANDS.get(signal, "")
        others = self.units(measured) if measured in self._places else [""] * len(si)
        each = zip(options, degrees, preset, self._places[signal], si, others, strict=True)
        return [
            option or angle or unit or self._of_file(signal, place, wanted) or other
            for option, angle, unit, place, wanted, other in each
        ]

    def percent_questions(self, position: np.ndarray) -> list[str]:
        """Questions about grippers whose positions (t, n) were read in degrees."""
        degrees = [unit_named(unit or "rad") == unit_named("deg") for unit in self.units("position")]
        return percent_questions(self._columns.robot, np.where(degrees, position, np.nan))

    def _from_preset(self, signal: str) -> Reading:
        return self._preset.signals.get(signal, Reading(""))

    def _reading(self, signal: str) -> Reading:
        """Reading of a signal; of the measured signal for a command whose reading states only columns."""
        reading = self._from_preset(signal)
        return self._from_preset(COMMANDS[signal]) if signal in COMMANDS and reading.plain else reading

    def _where(self, signal: str) -> str:
        if signal in self._stated:
            return f"units (--units): {signal}"
        return f"{self._preset.name or self._columns.source}: {signal}"

    @staticmethod
    def _each(units: str | Sequence[str], n: int, where: str) -> list[str]:
        each = [units] * n if isinstance(units, str) else list(units)
        if len(each) != n:
            raise WrongShape(f"{where}: {len(each)} units, but there are {n} joints")
        return each

    def _of_file(self, signal: str, place: int, wanted: str) -> str:
        """Unit that the file states for a column, if it is a unit of the quantity."""
        table = self._columns.table
        unit = table.unit(table.names[place]) if place >= 0 else ""
        entry = unit_named(unit)
        if not unit or (entry is not None and entry[0] == wanted):
            return unit
        if is_travel(unit) and wanted in ("rad", "m"):
            raise BadUnit(
                f"{self._columns.source}: column {table.names[place]} is in {unit}, which does not say of "
                f"what. Of the joint's travel: --units {signal}=% for -100 to 100, or {signal}=0-100%"
            )
        name = table.names[place]
        fact = f"{signal}: column {name} is in {unit}, which is no unit of {wanted}; it is read as it is"
        if fact not in self.facts:
            self.facts.append(fact)
        return ""


def with_rate(preset: Preset, columns: Columns, chosen: Mapping[str, Names], rate: float) -> Preset:
    """Preset for a file without time, with its sampling rate [Hz]."""
    stated = str(chosen.get("time") or preset.signals.get("time", Reading("")).column)
    column = stated if chosen.get("time") or stated in columns.table.names else own_time(columns.table)
    require_no_time(columns.source, column)
    others = {signal: reading for signal, reading in preset.signals.items() if signal != "time"}
    return replace(preset, signals=others, rate=rate)


def require_no_time(source: Path, column: str) -> None:
    """Refuse a rate for a file with a time column; `column` is "" if it has none."""
    if column:
        raise RecordingError(
            f"{source} has its own time, column {column}; --rate (rate) is for tables and arrays without time"
        )


def stamped(
    columns: Columns, preset: Preset, place: int | None, unit: str
) -> tuple[Table, np.ndarray, list[str]]:
    """Rows of a table that have a time, their time stamps (t,) [s], and sentences about their reading.

    `place` is the index of the time column, None if the preset has a rate; `unit` overrides the preset and
    the file. At least two rows need a time.
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
    stated = unit or preset_unit or table.unit(name)
    if table.units.get(name) == DATE:
        scale = 1.0
    elif not stated and (since_1970 := unit_since_1970(times)):
        scale = SINCE_1970[since_1970]
        date = datetime.fromtimestamp(times[0] * scale, UTC).isoformat(sep=" ", timespec="seconds")
        facts.append(f"time: {name} is read as {since_1970} since 1970, the first as {date} (UTC)")
    else:
        entry = unit_named(stated or "s")
        of_another = not (unit or preset_unit) and (entry is None or entry[0] != "s")
        where = "units (--units)" if unit else preset.name or str(source)
        scale = float(factors(["s"], ["" if of_another else stated], f"{where}: time")[0][0])
    return table, reading.numbers(times[:, None], f"{preset.name}: time")[:, 0] * scale, facts


def unit_since_1970(times: np.ndarray) -> str:
    """Unit of stamps (t,) since 1970, from the year and the rate; "" if it is s or unknown."""
    period = float(np.median(np.diff(times)))
    for unit, scale in SINCE_1970.items():
        if YEARS[0] < times[0] * scale < YEARS[1] and 1 / RATES[1] < period * scale < 1 / RATES[0]:
            return unit
    return ""
