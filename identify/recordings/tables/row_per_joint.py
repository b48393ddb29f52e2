"""Tables with one row per joint and sample, which become tables with one row per sample."""

import numpy as np

from .column_names import STAMPS, words_of
from .name_index import names_joints, stated_unit
from .table import Table

MOST = 64
"""Maximum number of joints of a robot; a column with more values counts samples."""
COMPLETE = 0.8
"""Minimum share of the cells with a value: every joint has about as many rows as the others."""


def by_sample(table: Table) -> Table:
    """The table with one row per sample, if it has one row per joint and sample; else the table itself.

    The columns of each joint have its name, or its number in the order of the identifiers, behind their name.
    Samples begin where a joint occurs again; their time is that of their first row.
    """
    for place in range(len(table.names)):
        identifiers = table.values[:, place]
        if not names_joints(table.names[place]) or not np.isfinite(identifiers).all():
            continue
        known, joint = np.unique(identifiers, return_inverse=True)
        if not 2 <= len(known) <= MOST or not np.array_equal(known, np.round(known)):
            continue
        for sample in (_cycles(joint), _moments(table)):
            if (sample[-1] + 1) * len(known) * COMPLETE <= len(joint):
                texts = table.labels.get(table.names[place], ())
                return _arranged(table, place, sample, joint, [texts[int(k) - 1] for k in known if texts])
    return table


def _cycles(joint: np.ndarray) -> np.ndarray:
    """Number of the sample of each row, which ends before a joint (t,) occurs again, shape (t,)."""
    seen: set[int] = set()
    begins = np.zeros(len(joint), int)
    for row, number in enumerate(joint.tolist()):
        if number in seen:
            begins[row] = 1
            seen.clear()
        seen.add(number)
    return np.cumsum(begins)


def _moments(table: Table) -> np.ndarray:
    """Number of the sample of each row if rows of one time are one sample, shape (t,)."""
    clocks = [place for place, name in enumerate(table.names) if STAMPS.intersection(words_of(name))]
    if not clocks:
        return np.arange(len(table.values))
    return np.asarray(np.unique(table.values[:, clocks[0]], return_inverse=True)[1])


def _arranged(table: Table, place: int, sample: np.ndarray, joint: np.ndarray, labels: list[str]) -> Table:
    """Rows (t,) of joints and samples as one row per sample; column `place` names the joint."""
    count = int(joint.max()) + 1
    names, columns, units = [], [], dict(table.units)
    for name, values in zip(table.names, table.values.T, strict=True):
        cells = np.full((int(sample.max()) + 1, count), np.nan)
        cells[sample, joint] = values
        if name == table.names[place]:
            continue
        if STAMPS.intersection(words_of(name)):
            names.append(name)
            columns.append(np.nanmin(cells, axis=1, initial=np.inf))
            continue
        bare, unit = stated_unit(name)
        each = [f"{bare}_{label}" for label in labels] or [f"{bare}{k}" for k in range(1, count + 1)]
        names += each
        columns += list(cells.T)
        units |= dict.fromkeys(each, units.get(name) or unit)
    lines = None if table.lines is None else table.lines[np.unique(sample, return_index=True)[1]]
    return table._replace(
        names=names, values=np.column_stack(columns), lines=lines, units={k: v for k, v in units.items() if v}
    )
