"""Writes the folder of a concealed case, all that the code under test is given, and its truth."""

import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from .plant.body import Body
from .record import FILTER_HZ, Run, low_pass, rms
from .robot import Robot

COLUMNS = "t, q1..qn [rad], i1..in [current unit], temp1..tempn [deg C]"
EQUATIONS = """\
# motor torque = drive_gain * current (+ constant offset where believed.terms.offset)
# motor torque + balancer torque = rigid body(q) + rotor_inertia*qdd + viscous*qd + coulomb*sign(qd)
# with sign(qd) = tanh(qd / 0.003); a term that is false in believed.terms is not in the model
# payload com/inertia: about its com, in the axes of the last link (= flange) frame
# inertia lists are xx xy xz yy yz zz
"""
BALANCER = """\
# balancer torque on its joint: q21 = phi + q; l = sqrt(d21^2 + d22^2 + 2 d21 d22 cos q21);
#   F = Kr l + K0; torque = -F d21 d22 sin(q21) / l
"""


def write_case(folder: Path, robot: Robot, runs: list[Run]) -> None:
    """Write case.toml, nominal.urdf and the runs of a case into a folder named after it."""
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    (folder / "nominal.urdf").write_text(urdf(robot))
    (folder / "case.toml").write_text(case_text(folder.name, robot, runs))
    for run in runs:
        _table(folder / "runs" / f"{run.plan.name}.csv.gz", robot, run)


def plain(value: Any) -> Any:
    """Arrays and numbers of numpy, as JSON and TOML know them."""
    return np.asarray(value).tolist()


def _table(path: Path, robot: Robot, run: Run) -> None:
    n = robot.arm.joints
    names = [f"{signal}{j}" for signal in ("q", "i") for j in range(1, n + 1)]
    columns, digits = [run.time, run.position, run.current], ["%.3f"] + ["%.7f"] * n + ["%.4f"] * n
    if robot.arm.warm:
        names += [f"temp{j}" for j in range(1, n + 1)]
        columns, digits = [*columns, run.temperature], digits + ["%.1f"] * n
    with gzip.open(path, "wt", compresslevel=1) as file:
        np.savetxt(file, np.column_stack(columns), digits, ",", header=",".join(["t", *names]), comments="")


def urdf(robot: Robot) -> str:
    """The nominal arm as URDF."""
    body, limits = robot.prior.body, robot.arm.limits
    parts = ['<?xml version="1.0"?>', f'<robot name="{robot.arm.name}">', '  <link name="base"/>']
    for j in range(robot.arm.joints):
        parts += [
            _link(body, j),
            _joint(body, j, [limits.lower[j], limits.upper[j], limits.velocity[j], limits.torque[j]]),
        ]
    parts += [
        '  <link name="flange"/>',
        '  <joint name="flange_joint" type="fixed">',
        f'    <parent link="link{robot.arm.joints}"/><child link="flange"/><origin xyz="0 0 0" rpy="0 0 0"/>',
        "  </joint>",
        "</robot>",
    ]
    return "\n".join(parts) + "\n"


def _link(body: Body, j: int) -> str:
    i = body.inertia[j]
    return (
        f'  <link name="link{j + 1}"><inertial>\n    <origin xyz="{_numbers(body.com[j])}" rpy="0 0 0"/>\n'
        f'    <mass value="{body.mass[j]:.9g}"/>\n'
        f'    <inertia ixx="{i[0, 0]:.9g}" ixy="{i[0, 1]:.9g}" ixz="{i[0, 2]:.9g}" '
        f'iyy="{i[1, 1]:.9g}" iyz="{i[1, 2]:.9g}" izz="{i[2, 2]:.9g}"/>\n  </inertial></link>'
    )


def _joint(body: Body, j: int, limits: list[float]) -> str:
    lower, upper, velocity, torque = limits
    angles = pin.rpy.matrixToRpy(body.rotation[j])
    parent = f"link{j}" if j else "base"
    return (
        f'  <joint name="joint{j + 1}" type="revolute">\n'
        f'    <parent link="{parent}"/><child link="link{j + 1}"/>\n'
        f'    <origin xyz="{_numbers(body.translation[j])}" rpy="{_numbers(angles)}"/><axis xyz="0 0 1"/>\n'
        f'    <limit lower="{lower:g}" upper="{upper:g}" velocity="{velocity:g}" effort="{torque:g}"/>\n'
        "  </joint>"
    )


def _numbers(values: np.ndarray) -> str:
    return " ".join(f"{value:.12g}" for value in values)


def case_text(name: str, robot: Robot, runs: list[Run]) -> str:
    """The text of case.toml."""
    arm, prior = robot.arm, robot.prior
    balanced = prior.balancer[0] >= 0
    tables: list[tuple[str, dict[str, Any]]] = [
        ("[case]", {"name": name, "format": 1}),
        ("[robot]", {"name": arm.name, "dof": arm.joints, "urdf": "nominal.urdf",
                     "joints": [f"joint{j}" for j in range(1, arm.joints + 1)]}),
        ("[signals]", {"sample_rate_hz": 500, "columns": COLUMNS,
                       "temperature": arm.warm, "encoder_resolution_rad": arm.encoder,
                       "encoder_side": "motor; the controller reports joint coordinates",
                       "current_resolution": arm.current}),
        ("[limits]", {"position_lower": arm.limits.lower, "position_upper": arm.limits.upper,
                      "velocity": arm.limits.velocity, "acceleration": arm.limits.acceleration,
                      "torque": arm.limits.torque}),
        ("[believed]", {"gravity": [0.0, 0.0, -9.81], "inertial_tolerance": prior.inertial_tolerance,
                        "drive_gain": _six(prior.gain), "drive_gain_tolerance": prior.gain_tolerance,
                        "gear_ratio": arm.gear, "rotor_inertia": _six(prior.rotor),
                        "rotor_inertia_tolerance": prior.inertial_tolerance, "friction_tolerance": 0.2,
                        "friction_viscous": _six(prior.viscous), "friction_coulomb": _six(prior.coulomb)}),
        ("[believed.terms]", {"rotor_inertia": prior.terms["rotor"], "viscous": prior.terms["viscous"],
                              "coulomb": prior.terms["coulomb"], "offset": prior.terms["offset"],
                              "balancer": bool(balanced)}),
    ]  # fmt: skip
    if balanced:
        joint, *values = prior.balancer
        keys = ("d21", "d22", "phi", "Kr", "K0")
        tables += [("[believed.balancer]", {"joint": int(joint) + 1, **dict(zip(keys, values, strict=True))})]
    for run in runs:
        tables += _run_tables(run)
    head = EQUATIONS + (BALANCER if balanced else "")
    return head + "".join(f"\n{title}\n{_lines(values)}" for title, values in tables)


def _run_tables(run: Run) -> list[tuple[str, dict[str, Any]]]:
    plan, seconds = run.plan, len(run.time) / 500.0
    values = {"file": f"runs/{plan.name}.csv.gz", "role": plan.role, "seconds": seconds,
              "motion": plan.motion, "bandwidth_hz": plan.bandwidth}  # fmt: skip
    if plan.sweep is not None:
        values["swept_sine_s"] = [round(share * seconds, 6) for share in plan.sweep]
    tables = [("[[runs]]", values)]
    if run.tool is not None:
        i = run.tool.inertia
        six = [i[0, 0], i[0, 1], i[0, 2], i[1, 1], i[1, 2], i[2, 2]]
        tables += [("[runs.payload]", {"mass": run.tool.mass, "com": run.tool.com, "inertia": six})]
    return tables


def _six(values: np.ndarray) -> list[float]:
    """Six significant digits, as a person writes them."""
    return [float(f"{value:.6g}") for value in values]


def _lines(values: dict[str, Any]) -> str:
    return "".join(f"{key} = {_toml(value)}\n" for key, value in values.items())


def _toml(value: Any) -> str:
    # JSON's strings, numbers, booleans and lists are TOML's too.
    return json.dumps(value, default=plain)


def truth_of(robot: Robot, effects: list[dict[str, Any]], validate: Run) -> dict[str, Any]:
    """What is concealed in a robot, and the noise floor of the run held out."""
    machine = robot.machine
    return {
        "robot": robot.arm.name,
        "effects": effects,
        "noise_floor": rms(validate.noise),
        "noise_floor_filtered": rms(low_pass(validate.noise)),
        "noise_filter_hz": FILTER_HZ,
        "torque_range": 2.0 * robot.peak,
        "inertial_tolerance": robot.prior.inertial_tolerance,
        "plant": {
            "gain": robot.recorder.gain,
            "rotor_inertia": np.diag(machine.rotor),
            "viscous": np.diag(machine.friction.viscous),
            "coulomb": machine.friction.coulomb,
            "offset": machine.offset,
            "gravity": machine.body.gravity,
        },
    }


def write_truth(folder: Path, name: str, truth: dict[str, Any]) -> None:
    """Write it where the code under test does not look."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.json").write_text(json.dumps({"name": name, **truth}, indent=1, default=plain) + "\n")
