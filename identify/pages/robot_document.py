"""The nominal robot, as described before any measurement."""

import numpy as np

from ..arm.robot import Robot
from ..document.document import Block, Cell, Number, Numbers, Paragraph, Section, Table
from ..effects import Effect, Prior, name_of
from ..model import Model
from ..text_table import NORMAL_95

OPEN = "open"
"""Text for parameters without a nominal value."""


def robot_sections(model: Model) -> list[Section]:
    """Joints, links and effects."""
    robot = model.robot
    note = (
        f"{robot.name} as described before any measurement. These nominal values are the starting point of "
        "all parameters. ±: half of the 95 % interval of the prior; a dash: not stated."
    )
    links = (
        f"Inertias are known to ± {100 * NORMAL_95 * robot.inertial_tolerance:.3g} % (95 %); centers of mass "
        "are in the frames of their links."
    )
    return [
        Section("joints", "Joints", [Paragraph(note), _joints(robot)]),
        Section("links", "Links", [Paragraph(links), _links(robot)]),
        Section("effects", "Effects other than inertia", [_effects(model)]),
    ]


def _joints(robot: Robot) -> Table:
    limits = robot.limits
    head = [
        "joint",
        "kind",
        "from",
        "to",
        "velocity, /s",
        "acceleration, /s²",
        f"torque [{_column_unit(robot, 'N m')}]",
        "gear",
    ]
    columns = (
        *(limits.position_lower, limits.position_upper, limits.velocity, limits.acceleration),
        *(limits.torque, robot.gear_ratio),
    )
    rows: list[list[Cell]] = []
    for joint, name in enumerate(robot.joints):
        kind = "revolute, rad" if robot.revolute[joint] else "prismatic, m"
        cells = [Number(column[joint], 3) for column in columns]
        rows.append([name, kind, *cells, _gain(robot, joint)])
    return Table([*head, f"drive gain [{_column_unit(robot, 'N m/A')}]"], rows, words=(1,))


def _column_unit(robot: Robot, turning: str) -> str:
    """Units of a column for the joint kinds of the robot; `turning` is the unit for revolute joints."""
    return ", ".join(dict.fromkeys(robot.units(turning)))


def _gain(robot: Robot, joint: int) -> Cell:
    """The nominal drive gain; a dash where the robot's description has none."""
    if np.all(robot.drive_gain == 1.0):
        return "-"
    gain = float(robot.drive_gain[joint])
    return _with(gain, float(robot.drive_gain_tolerance[joint]) * abs(gain))


def _links(robot: Robot) -> Table:
    rows: list[list[Cell]] = []
    for joint, name in enumerate(robot.joints):
        body = robot.kinematics.inertias[joint + 1]
        moments = np.diag(body.inertia)
        rows.append(
            [
                name, Number(body.mass, 4), *(Number(value, 3) for value in body.lever),
                *(Number(value, 3) for value in moments),
            ]
        )  # fmt: skip
    head = ["link of", "mass [kg]", "center x [m]", "y", "z", "inertia about it: xx [kg m²]", "yy", "zz"]
    return Table(head, rows)


def _effects(model: Model) -> Block:
    """One row per kind of parameter and one column per joint."""
    priors = dict(zip(model.names, model.priors, strict=True))
    rows: list[list[Cell]] = []
    for effect in model.effects:
        if effect.of_links:
            continue
        first = name_of(effect).replace("_", " ")
        for letters, measure, cells in _rows(effect, model.robot, priors):
            rows.append([first, letters, measure, *cells])
            first = ""
    if not rows:
        return Paragraph("None: the nominal arm consists of rigid links only.")
    return Table(["effect", "parameter", "unit", *model.robot.joints], rows, words=(1, 2))


def _rows(effect: Effect, robot: Robot, priors: dict[str, Prior]) -> list[tuple[str, str, list[Cell]]]:
    """Letters, unit and priors of each kind of parameter; all unstated kinds share a row."""
    rows: dict[str, tuple[str, list[Cell]]] = {}
    if known := [f"{name} {value:g}" for name, value in effect.known]:
        rows[f"known: {', '.join(known)}"] = "", [""] * robot.dof
    for parameter, joint in zip(effect.parameters(robot), effect.parameter_joints(robot), strict=True):
        letters = parameter.name if joint is None else parameter.name.removesuffix(str(joint + 1))
        _, cells = rows.setdefault(letters, (parameter.unit, [""] * robot.dof))
        cells[joint or 0] = _prior(priors[parameter.name])
    unstated = [letters for letters, (_, cells) in rows.items() if any(cells) and set(cells) <= {"", OPEN}]
    stated = [
        (letters, measure, cells) for letters, (measure, cells) in rows.items() if letters not in unstated
    ]
    return [*stated, (f"{', '.join(unstated)}: {OPEN}", "", [""] * robot.dof)] if unstated else stated


def _prior(prior: Prior) -> Cell:
    return _with(prior.value, prior.std) if np.isfinite(prior.std) else OPEN


def _with(value: float, std: float) -> Cell:
    return Numbers("{} ± {}", (Number(value, 4), Number(NORMAL_95 * std, 2)))
