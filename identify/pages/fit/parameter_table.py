"""The table of base parameters in a fit's summary."""

from collections.abc import Iterator, Sequence
from os.path import commonprefix

import numpy as np

from ...effects import Effect, name_of
from ...fit.fit import Fit
from ...fit.fit_warnings import OPEN
from ...fit.verdict import NORMAL_95, SURPRISE, payload_centres, surprises
from ...model import Model
from ...text_table import at_point, digits, paragraph, table

LABEL = 14
"""Characters of a joint's name in the table of parameters; the head has it in full."""


def unit_of(fit: Fit, turning: str) -> str:
    """Unit of a column over all joints, given that of revolute ones; both where there are both kinds."""
    return ", ".join(dict.fromkeys(fit.model.robot.units(turning)))


def parameter_table(fit: Fit) -> list[str]:
    """Base parameters effect by effect, the payload's centre, and what was dropped."""
    unit = f"unit/({unit_of(fit, 'N m/A')})" if fit.unscaled else "unit"
    head = ["name", "joint", "value", unit, "std %", "from", "to (95%)", "nominal", "+- std", "note"]
    places = _places(fit.model)
    rows: list[list[str]] = []
    columns = [fit.base.parameters[column].name for column in fit.base.kept]
    headings = [places[name][0] for name in columns]
    for heading in dict.fromkeys(headings):
        members = [row for row, of in enumerate(headings) if of == heading]
        rows += [[heading], *_group(fit, members, [places[columns[row]][1] for row in members])]
    lines = table(head, rows, left=(0, 1, 3, 9))
    lines += [line for words in payload_centres(fit) for line in paragraph(words)]
    lines += paragraph(
        "std %: standard deviation over value, with the residual's autocorrelation in it. "
        f"open: above {OPEN:g} %. "
        f"off nominal: more than {SURPRISE:g} standard deviations of value and nominal value together."
    )
    return lines + _dropped(fit)


def _group(fit: Fit, members: Sequence[int], joints: Sequence[str]) -> list[list[str]]:
    """Rows of the parameters of one effect."""
    value, std = fit.estimate.values[members], fit.estimate.std[members]
    nominal, tolerance = fit.prior[0][members], fit.prior[1][members]
    with np.errstate(over="ignore"):  # a value of next to nothing is open by infinitely many per cent
        percent = 100 * std / np.maximum(np.abs(value), np.finfo(float).tiny)
    if fit.unscaled:  # values in amperes compare with no prior
        tolerance = np.full(len(tolerance), np.inf)
    held = np.isfinite(tolerance)
    columns = [
        [digits(v) for v in values]
        for values in (
            value,
            percent,
            value - NORMAL_95 * std,
            value + NORMAL_95 * std,
            np.where(held, nominal, np.nan),
            tolerance,
        )
    ]
    values, percents, low, high, prior, spread = (at_point(column) for column in columns)
    far = surprises(fit)
    notes = [
        ", ".join(note for note, on in (("open", p > OPEN), ("off nominal", fit.names[row] in far)) if on)
        or "kept"
        for row, p in zip(members, percent, strict=True)
    ]
    names = [f"  {fit.names[row]}" for row in members]
    units = [fit.base.units[row] for row in members]
    rows = zip(names, joints, values, units, percents, low, high, prior, spread, notes, strict=True)
    return [list(row) for row in rows]


def _places(model: Model) -> dict[str, tuple[str, str]]:
    """Heading and joint of each parameter."""
    return {
        parameter.name: (f"{name_of(effect)} {effect.payload}".strip(), joint)
        for effect in model.effects
        for parameter, joint in zip(effect.parameters(model.robot), joints_of(effect, model), strict=True)
    }


def joints_of(effect: Effect, model: Model) -> Iterator[str]:
    """Joint at which each parameter of an effect acts; empty where there is not one."""
    robot = model.robot
    labels = list(_labels(robot.joints).values())
    return ("" if joint is None else labels[joint] for joint in effect.parameter_joints(robot))


def _labels(joints: Sequence[str]) -> dict[str, str]:
    """Names of joints, short enough for a column: without an ending they all share, such as "_joint".

    Where names that are cut at their end are no longer told apart, all are cut at their beginning.
    """
    shared = len(commonprefix([joint[::-1] for joint in joints])) if len(joints) > 1 else 0
    shared = 0 if shared == min(map(len, joints)) else shared
    bare = [joint[: len(joint) - shared] for joint in joints]
    cut = [b if len(b) <= LABEL else b[: LABEL - 1] + "~" for b in bare]
    if len(set(cut)) < len(set(bare)):
        cut = [b if len(b) <= LABEL else "~" + b[1 - LABEL :] for b in bare]
    return dict(zip(joints, cut, strict=True))


def _dropped(fit: Fit) -> list[str]:
    if not fit.dropped:
        return []
    places = _places(fit.model)
    items = [
        f"{name} ({joint}) {digits(value)}" if joint else f"{name} {digits(value)}"
        for name, value in fit.dropped.items()
        for _, joint in (places.get(name) or places[name.removesuffix("R")],)
    ]
    text = (
        f"Dropped, {len(items)} that may all be zero as far as these runs show (joint, value before): "
        + "; ".join(item.replace(" ", "\N{NO-BREAK SPACE}") for item in items)
    )
    return ["", *(line.replace("\N{NO-BREAK SPACE}", " ") for line in paragraph(text, "  ", ""))]
