"""Tables of base parameters: estimate, interval, nominal value and note; and which agree between runs."""

import numpy as np

from ..document.document import Block, Heading, Number, Paragraph, Picture, Row, Section, Statements, Table
from ..effects import name_of
from ..fit.fit import Fit
from ..fit.fit_warnings import OPEN
from ..fit.repeatability import FEWEST, SHORTEST, SPEED, TEMPERATURE, TIME, Repeatability, Repeated
from ..fit.verdict import SURPRISE, payload_centres, surprises
from ..text_table import NORMAL_95, digits, percent
from .fit_plots import interval_bar

UNITS = {SPEED: "rad/s", TEMPERATURE: "\N{DEGREE SIGN}C", TIME: "min"}
"""Units of the conditions; settings have none."""


def parameters_section(fit: Fit) -> Section:
    """Parameters by effect, payload centers, and uncertain, dropped and adjusted parameters."""
    nominal = fit.estimate.nominal_gains and np.any(fit.estimate.gain_std)
    gains = " and the tolerance of nominal drive gains" if nominal else ""
    note = (
        "XX to ZZ: inertia about the frame of the joint; MX, MY, MZ: mass times center of mass; Ia: rotor "
        "inertia; Fv, Fc: viscous and Coulomb friction; Off: offset. The number is that of the joint. R: a "
        "combination of several parameters, listed below. ±: half of the 95 % interval, which includes the "
        f"residual's autocorrelation{gains}. uncertain: the standard deviation exceeds {OPEN:g} % of the "
        f"value. off nominal: value and nominal value differ by more than {SURPRISE:g} combined standard "
        "deviations."
    )
    plot = "Gray: nominal value with its 95 % interval. Blue: estimate with its 95 % interval."
    centres = [Paragraph(words, "") for words in payload_centres(fit)]
    blocks: list[Block] = [Paragraph(note), Paragraph(plot, "plot"), _table(fit), *centres]
    return Section("parameters", "Parameters", [*blocks, *_open(fit), *_dropped(fit), *_moved(fit)])


def unit_head(fit: Fit) -> str:
    """Head of a column of units; values are per unit of the drive gain if that is unknown."""
    per = ", ".join(dict.fromkeys(fit.model.robot.units("N m/A")))
    return f"unit/({per})" if fit.unscaled else "unit"


def _table(fit: Fit) -> Table:
    """One row per parameter, below the name of its effect."""
    names = [fit.base.parameters[column].name for column in fit.base.kept]
    effects = {
        parameter.name: f"{name_of(effect)} {effect.payload}".replace("_", " ").strip()
        for effect in fit.model.effects
        for parameter in effect.parameters(fit.model.robot)
    }
    far = surprises(fit)
    # Values in amperes cannot be compared with a prior.
    deviation = np.full(len(names), np.inf) if fit.unscaled else fit.prior[1]
    rows: list[Row] = []
    for effect in dict.fromkeys(effects[name] for name in names):
        rows.append([effect])
        rows += [
            _row(fit, place, float(deviation[place]), far)
            for place, name in enumerate(names)
            if effects[name] == effect
        ]
    head = ["name", "value", "± 95 %", unit_head(fit), "nominal", "± 95 %", "note", "against nominal"]
    return Table(head, rows, words=(3, 6, 7))


def _row(fit: Fit, place: int, deviation: float, far: list[str]) -> Row:
    name, value, std = fit.names[place], fit.estimate.values[place], fit.estimate.std[place]
    nominal, stated = float(fit.prior[0][place]), np.isfinite(deviation)
    is_open = 100.0 * std > OPEN * abs(value)
    notes = [note for note, on in (("uncertain", is_open), ("off nominal", name in far)) if on]
    return [
        name, Number(value), Number(NORMAL_95 * std, 2), fit.base.units[place],
        Number(nominal if stated else np.nan), Number(NORMAL_95 * deviation, 2), ", ".join(notes),
        Picture(interval_bar(value, std, nominal, deviation)),
    ]  # fmt: skip


def _open(fit: Fit) -> list[Block]:
    if not fit.unclear:
        return []
    rows: list[Row] = [
        [unclear.name, Number(unclear.std_percent, 3), unclear.hint] for unclear in fit.unclear
    ]
    table = Table(["name", "std, %", "motion that would determine it"], rows, words=(2,))
    return [Heading("Uncertain"), table]


def _dropped(fit: Fit) -> list[Block]:
    if not fit.dropped:
        return []
    count = len(fit.dropped)
    note = f"{count} parameters are indistinguishable from zero and were set to 0; their estimates were:"
    units = {parameter.name: parameter.unit for parameter in fit.base.parameters}
    items = [
        f"{name} {digits(value, 3)} {units.get(name) or units.get(name.removesuffix('R'), '')}".strip()
        for name, value in fit.dropped.items()
    ]
    return [Heading("Dropped"), Paragraph(note), Statements(["; ".join(items)])]


def _moved(fit: Fit) -> list[Block]:
    """Physically inconsistent values, and the values that export and simulation use instead."""
    if not fit.moved:
        return []
    note = (
        "These values are physically inconsistent, even within their 95 % intervals. Export and simulation "
        "use the nearest consistent values, by the covariance of the fit. far: distance between the two in "
        "standard deviations."
    )
    rows: list[Row] = [
        [m.name, Number(m.value), Number(m.exported), Number(m.deviations, 3)] for m in fit.moved
    ]
    return [Heading("Exported otherwise"), Paragraph(note), Table(["name", "value", "exported", "far"], rows)]


def repeatability_section(repeatability: Repeatability, unit: str) -> Section:
    """How many parameters agree, and a table of those that differ under the head `unit`."""
    blocks: list[Block] = [Statements([agreement_sentence(repeatability)])]
    if repeatability.differing:
        note = (
            "Between: standard deviation between parts beyond that of the estimates. Probability: that of at "
            "least this scatter if the parameter is the same in all parts. Follows: conditions that explain "
            "the differences, each by itself, with the change per unit."
        )
        rows: list[Row] = [_repeated_row(parameter, repeatability) for parameter in repeatability.differing]
        head = ["parameter", "mean", "between", unit, "between, %", "probability", "follows"]
        blocks += [Paragraph(note), Table(head, rows, words=(3, 5, 6))]
    return Section("repeatability", "Repeatability", blocks)


def agreement_sentence(repeatability: Repeatability) -> str:
    """Number of parts, of parameters, and of those that agree."""
    parts, count = repeatability.parts, len(repeatability.parameters)
    if len(parts) < 2:
        return f"Nothing to compare: this needs two runs, or parts of a run, of {SHORTEST:g} s each."
    if not count:
        return "No part alone determines a base parameter: record longer runs that move all joints."
    runs = len({part.run for part in parts})
    split = f"{runs} runs" if runs == len(parts) else f"{len(parts)} parts of {runs} run{'s' * (runs > 1)}"
    differing = len(repeatability.differing)
    known = sum(_determined(parameter) for parameter in repeatability.parameters)
    seen = (
        f"A part alone determines {known} of the {count} to {OPEN:g} % or better; of the others, only larger "
        "differences would be seen."
    )
    if not differing:
        return (
            f"All {count} base parameters agree between {split}, each fitted alone: they scatter as their "
            f"intervals say. {seen}"
        )
    return (
        f"{count - differing} of {count} base parameters agree between {split}, each fitted alone; "
        f"{differing} scatter{'s' * (differing == 1)} more than their intervals say. {seen}"
    )


def _determined(parameter: Repeated) -> bool:
    """Whether the median standard deviation of the parts is below `OPEN` percent of the mean."""
    std = [value for value in parameter.std if value is not None]
    return bool(100 * np.median(std) <= OPEN * abs(parameter.mean))


def _repeated_row(parameter: Repeated, repeatability: Repeatability) -> Row:
    relative = 100 * parameter.deviation / abs(parameter.mean) if parameter.mean else float("nan")
    return [
        parameter.name, Number(parameter.mean), Number(parameter.deviation, 2), parameter.unit,
        Number(relative, 2), percent(parameter.probability), _follows(parameter, repeatability),
    ]  # fmt: skip


def _follows(parameter: Repeated, repeatability: Repeatability) -> str:
    """Conditions with the change of the parameter per unit."""
    if trends := parameter.follows:
        return "; ".join(
            f"{trend.condition}, {digits(trend.slope, 3)} ± {digits(NORMAL_95 * trend.std, 2)} per "
            f"{UNITS.get(trend.condition, 'unit')}"
            for trend in trends
        )
    if len(repeatability.parts) < FEWEST:
        return f"undecided: {FEWEST} parts are needed"
    return f"not {' or '.join(repeatability.conditions)}"
