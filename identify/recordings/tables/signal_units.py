"""Units of the columns of a table: stated with the import, by its preset, or by the file itself."""

from collections.abc import Mapping, Sequence

import numpy as np

from ...errors import BadUnit, WrongShape
from ..recording import SIGNALS, Signal
from ..units import ANGLES, COMMANDS, factors, is_travel, unit_named
from .columns import Columns
from .preset import Preset, Reading

Units = Mapping[str, str | Sequence[str]]


class SignalUnits:
    """Signals of a table in the units of `SIGNALS`.

    The unit of a column is the first that is stated: with the import, by `degrees`, by the preset, by the
    file; for a command, by the measured signal. Otherwise it is the SI unit.

    Attributes:
        facts: Sentences about units in the file that were not applied.
    """

    def __init__(
        self,
        columns: Columns,
        preset: Preset,
        places: Mapping[str, Sequence[int]],
        stated: Units,
        degrees: bool,
    ) -> None:
        self.facts: list[str] = []
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
        stated = [
            option or angle or unit for option, angle, unit in zip(options, degrees, preset, strict=True)
        ]
        each = zip(stated, self._places[signal], si, strict=True)
        stated = [unit or self._of_file(signal, place, wanted) for unit, place, wanted in each]
        measured = COMMANDS.get(signal, "")
        others = self.units(measured) if measured in self._places else [""] * len(si)
        return [unit or other for unit, other in zip(stated, others, strict=True)]

    def in_degrees(self) -> np.ndarray:
        """Joints whose positions are in degrees, bool (n,)."""
        return np.array([unit_named(unit or "rad") == unit_named("deg") for unit in self.units("position")])

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
        """Unit that the file states for a column, if it is a unit of the quantity.

        Raises:
            BadUnit: It is percent for a position, which is ambiguous.
        """
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
