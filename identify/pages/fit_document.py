"""Content of a fit page: verdict, gains, parameters, runs, friction, conditioning, structure, filters."""

import numpy as np

from ..document.document import (
    Block,
    Document,
    Figure,
    Grid,
    Heading,
    Marked,
    Number,
    Numbers,
    Paragraph,
    Picture,
    Row,
    Section,
    Statements,
    Table,
)
from ..document.html import html
from ..effects import Effect, name_of
from ..fit.agreement import Agreement, Scores
from ..fit.estimators.least_squares import given_nominal
from ..fit.fit import Fit
from ..fit.verdict import JointState, gains_estimated, joint_verdicts, judged, verdict
from ..model import Model
from ..text_table import NORMAL_95, digits
from .fit_parameters import agreement_sentence, parameters_section, repeatability_section, unit_head
from .fit_plots import ROOM_TEMPERATURE, friction_plot, interval_bar, measured_unit, torque_plot
from .svg import COLUMNS

STRETCHES = 20_000
"""Line segments in all plots of runs together; at about 33 bytes each, they take 0.7 MB."""
NO_SAMPLES = (
    "There are no plots because this fit was loaded without the samples of its runs. "
    "Identify again from the recordings to see them."
)
WORST_PAIRS = 12
"""Number of pairs of correlated parameters that are listed."""


def fit_document(fit: Fit) -> Document:
    """The document of a fit."""
    repeated = [] if fit.repeatability is None else [agreement_sentence(fit.repeatability)]
    brief: list[Block] = [Statements([*repeated, *verdict(fit)]), _brief_table(fit)]
    title = f"Identified dynamics of {fit.model.robot.name}"
    return Document(title, "", fit_sections(fit), _facts(fit), brief)


def report_html(fit: Fit) -> str:
    """The document as one self-contained HTML page."""
    return html(fit_document(fit))


def fit_sections(fit: Fit) -> list[Section]:
    """All sections, the verdict first."""
    known = fit.repeatability
    return [
        Section("verdict", "Verdict", verdict_blocks(fit)),
        Section("gains", "Drive gains", _gains(fit)),
        parameters_section(fit),
        Section("runs", "Runs", _runs(fit)),
        *([] if known is None else [repeatability_section(known, unit_head(fit))]),
        Section("friction", "Friction", _friction(fit), detail=True),
        Section("conditioning", "Conditioning", _conditioning(fit), detail=True),
        Section("structure", "Composition of base parameters", _structure(fit)),
        Section("data", "Filters", _data(fit)),
    ]


def verdict_blocks(fit: Fit) -> list[Block]:
    """Verdict as sentences, and a table of each joint's worst run."""
    return [Statements(verdict(fit), "verdict"), *_joint_table(fit)]


def _facts(fit: Fit) -> list[tuple[str, str]]:
    robot, held_out = fit.model.robot, ", ".join(run.run for run in fit.validation)
    rank = len(fit.names) + len(fit.dropped)
    return [
        ("Robot", robot.name),
        ("Joints", ", ".join(f"{number} {joint}" for number, joint in enumerate(robot.joints, 1))),
        (
            "Effects",
            ", ".join(dict.fromkeys(name_of(effect).replace("_", " ") for effect in fit.model.effects)),
        ),
        ("Method", fit.estimate.method),
        ("Identified from", ", ".join(fit.runs)),
        *([("Validated on", held_out)] if held_out else []),
        ("Base parameters", f"{rank} identifiable, {len(fit.names) if fit.dropped else 'all'} kept"),
        ("Condition number", digits(fit.condition, 3)),
    ]


def _joint_table(fit: Fit) -> list[Table]:
    runs = {run.run: run for run in judged(fit)}
    rows: list[Row] = []
    for joint, verdict_of in enumerate(joint_verdicts(fit)):
        run = runs[verdict_of.run]
        kind = {JointState.EXPLAINED: "good", JointState.FAR_ABOVE: "bad"}.get(verdict_of.state, "middling")
        words = verdict_of.state.value  # the verdict states the reason once, for all joints
        over_noise, relative = verdict_of.over_noise, 100 * run.relative[joint]
        values = (over_noise, run.residual_rms[joint], run.noise[joint], relative)
        rows.append(
            [
                verdict_of.joint, Marked(words, kind), *(Number(value, 3) for value in values),
                Number(run.r_squared[joint], 5), measured_unit(fit, joint), run.run,
            ]
        )  # fmt: skip
    head = ["joint", "verdict", "residual / noise", "residual rms", "noise", "residual, % of torque"]
    return [Table([*head, "R\u00b2", "unit", "worst run"], rows, words=(1, 7, 8))] if rows else []


def _brief_table(fit: Fit) -> Table:
    """Residual of each joint in its worst run, and its drive gain if that was estimated."""
    [*residuals], estimated = _joint_table(fit), gains_estimated(fit)
    gains = _gain_table(fit, estimated).only(0, 1, 2, 3, 6)
    if not residuals:
        return gains
    return (
        residuals[0].only(0, 1, 2, 3, 7).beside(gains) if estimated else residuals[0].only(0, 1, 2, 3, 7, 5)
    )


def _gains(fit: Fit) -> list[Block]:
    estimated = gains_estimated(fit)
    if not estimated and (fit.unscaled or fit.measures == "torque"):
        return []  # the verdict has the reason
    note = (
        "Torque per motor current, signed. Gray: nominal value with its 95 % interval. Blue: estimate with "
        "its 95 % interval. An arrow points to an estimate outside the scale."
    )
    return [Paragraph(note, "plot"), _gain_table(fit, estimated)]


def _gain_table(fit: Fit, estimated: bool) -> Table:
    robot, estimate = fit.model.robot, fit.estimate
    rows: list[Row] = []
    for joint, name in enumerate(robot.joints):
        gain, std, prior = estimate.gain[joint], estimate.gain_std[joint], robot.drive_gain[joint]
        tolerance = robot.drive_gain_tolerance[joint] * abs(prior)
        stated = not fit.gains_unstated  # otherwise the nominal gain is only a placeholder of 1
        known = prior if stated else np.nan
        rows.append(
            [
                name, Number(gain, 5), Number(NORMAL_95 * std if std > 0.0 else np.nan, 2),
                f"{robot.units('N m')[joint]}/A", Number(known),
                Number(NORMAL_95 * tolerance if stated else np.nan, 2),
                Number(100 * (gain / known - 1) if estimated else np.nan, 2),
                Picture(interval_bar(gain, std, prior, tolerance) if estimated and stated else ""),
            ]
        )  # fmt: skip
    head = ["joint", "gain", "± 95 %", "unit", "nominal", "± 95 %", "off nominal, %", "against nominal"]
    return Table(head, rows, words=(3, 7))


def _runs(fit: Fit) -> list[Block]:
    roles: list[tuple[Agreement | Scores, str]] = [(run, "held out") for run in fit.validation]
    roles += [(run, "used") for run in fit.agreement] + [(run, "not judged") for run in fit.apart]
    drawn = list(roles)
    roles = roles or [(run, "held out" if run.held_out else "used") for run in fit.scores]
    rows: list[Row] = [[run.run, role, *map(_run_cell, run.over_noise, run.relative)] for run, role in roles]
    note = "Residual of each run and joint: multiple of the noise; percentage of the torque."
    blocks: list[Block] = [Paragraph(note), Table(["run", "role", *fit.model.robot.joints], rows, words=(1,))]
    if not drawn:
        return [Paragraph(NO_SAMPLES), *(blocks if rows else [])]
    columns = int(np.clip(STRETCHES // (len(drawn) * fit.model.robot.dof), 40, COLUMNS))
    plots = (
        "Measured and predicted torque share a panel. Samples in which the joint stands still are not "
        "judged, and their residuals may leave the frame. Of a long run, the torque panel shows the stretch "
        "with the largest residual."
    )
    blocks.append(Paragraph(plots, "plot"))
    for run, role in drawn:
        if isinstance(run, Agreement):
            blocks += [Heading(f"{run.run} ({role})"), Grid(_run_plots(fit, run, columns), "two alike")]
    return blocks


def _run_cell(over_noise: float, relative: float) -> Numbers:
    return Numbers("{}; {} %", (Number(over_noise, 3), Number(100 * relative, 2)))


def _run_plots(fit: Fit, run: Agreement, columns: int) -> list[Figure]:
    return [
        Figure(
            joint,
            f"residual {digits(run.residual_rms[j], 3)} {measured_unit(fit, j)}, "
            f"{run.over_noise[j]:.2f} x noise, {digits(100 * run.relative[j], 2)} % of the torque",
            torque_plot(run, fit.model.robot, j, columns, measured_unit(fit, j)),
        )
        for j, joint in enumerate(fit.model.robot.joints)
    ]


def _friction(fit: Fit) -> list[Block]:
    note = (
        "Friction torque over velocity, excluding the torque transmitted to the link. Dots: measured torque "
        "of the fitted runs minus all other model terms; where they leave the curve together, the friction "
        "model has the wrong form. Friction that depends on other quantities is drawn at the middle of the "
        f"position range and at {ROOM_TEMPERATURE:g}\u00a0\u00b0C."
    )
    figures = [Figure(joint, "", friction_plot(fit, j)) for j, joint in enumerate(fit.model.robot.joints)]
    without = [] if fit.agreement else [Paragraph(NO_SAMPLES)]
    return [Paragraph(note), *without, Grid(figures, "three alike")]


def _conditioning(fit: Fit) -> list[Block]:
    note = (
        f"Condition number of the weighted regressor with unit columns: {digits(fit.condition, 3)}. It is "
        "how much better the data determine the best-determined combination of parameters than the worst. "
        "The table lists the pairs that the data separate worst; near -1 or 1, only their sum or difference "
        "is known."
    )
    rows: list[Row] = [[f"{a} and {b}", Number(r)] for a, b, r in correlations(fit)]
    return [Paragraph(note), Table(["pair", "correlation"], rows)]


def correlations(fit: Fit) -> list[tuple[str, str, float]]:
    """Most correlated pairs of estimates, estimated gains included, the worst first."""
    covariance = fit.estimate.covariance if gains_estimated(fit) else given_nominal(fit.estimate)
    std = np.sqrt(np.diag(covariance))
    estimated = np.flatnonzero(std > 0.0)
    scaled = covariance[np.ix_(estimated, estimated)] / np.outer(std[estimated], std[estimated])
    names = [*fit.names, *(f"gain of {joint}" for joint in fit.model.robot.joints)]
    first, second = np.triu_indices(len(estimated), 1)
    worst = np.argsort(-np.abs(scaled[first, second]), kind="stable")[:WORST_PAIRS]
    pairs = zip(first[worst], second[worst], strict=True)
    return [(names[estimated[a]], names[estimated[b]], float(scaled[a, b])) for a, b in pairs]


def _structure(fit: Fit) -> list[Block]:
    """Regrouped parameters, parameters without any effect on the torque, and shapes of effects."""
    structure = fit.structure or fit.base
    alone = len(structure.kept) - len(structure.expressions)
    single = [f"The other {alone} are single parameters."] if alone else []
    blocks: list[Block] = [Statements([*structure.expressions, *single])]
    if hidden := structure.without_effect:
        blocks.append(
            Paragraph(f"No motion of this arm makes these visible in a torque: {', '.join(hidden)}.", "")
        )
    shapes = [line for effect in fit.model.effects if (line := _shape(effect, fit.model))]
    return (
        [*blocks, Heading("Shapes of effects, as stated or fitted"), Statements(shapes)] if shapes else blocks
    )


def _shape(effect: Effect, model: Model) -> str:
    """Nonlinear parameters of an effect and the joints on which it acts, in words; empty without any."""
    robot = model.robot
    joints = [joint for joint in effect.parameter_joints(robot) if joint is not None]
    values = []
    for name, shape in effect.shapes().items():
        units = dict.fromkeys(robot.unit(joint, shape.unit) for joint in joints) or [shape.unit]
        values.append(f"{name} {getattr(effect, name):.4g} {', '.join(units)}")
    where = ", ".join(dict.fromkeys(robot.joints[joint] for joint in joints)) or "arm"
    return f"{name_of(effect).replace('_', ' ')} ({where}): {', '.join(values)}" if values else ""


def _data(fit: Fit) -> list[Block]:
    filtering, units = fit.filtering, ", ".join(dict.fromkeys(fit.model.robot.units("rad/s")))
    sources = sorted({run.noise_source for run in (*fit.agreement, *fit.validation)} - {""})
    rows: list[Row] = [
        ["sampling rate", _filter(filtering.rate), "Hz"],
        ["low-pass of positions before differentiation", _filter(filtering.position_cutoff), "Hz"],
        ["low-pass and decimation of torque and regressor", _filter(filtering.torque_cutoff), "Hz"],
        ["standstill below", _filter(filtering.standstill), units]
        if filtering.standstill is not None
        else ["standstill below", "1 %", "of each joint's usual speed"],
        ["equations used (decimated samples times joints)", Number(fit.rows, len(str(fit.rows))), ""],
        *([["noise floor measured at", " and ".join(sources), ""]] if sources else []),
    ]
    return [Table(["filter", "value", "unit"], rows, words=(2,))]


def _filter(value: float | None) -> str | Number:
    return "from the data" if value is None else Number(value)
