"""Real recordings with models that users have: how far simulation is off, with both answers.

Errors are those of the tool point 0.1, 0.5 and 2 s after starts in the recorded states, with the original
file, with the file as answered, and with effects attached to it. Where a log has torque or current, it drives
the simulation. Logs of hobby servos and of legs hold commands and positions, which position servos follow.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from common import Kept, show
from parts.real.data import DE_LUCA, piece

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.in_mujoco.distances import Distances
from exidyn.identification.in_mujoco.gap import gap
from exidyn.identification.in_mujoco.replay import POSITION, TORQUE, Run
from exidyn.identification.in_mujoco.trial import Source, Trial
from exidyn.identification.model import Model
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model

from .score import said

SERVO_GAIN = 0.53
"""Torque of the Feetech servo per volt, by known masses [N m/V]; see its KNOWN.md."""
PENDULUMS = ((535, 100), (741, 150), (969, 100), (1168, 150))
"""Mass [g] and length of the arm [mm]."""
ARM_MASS = {100: 0.036, 150: 0.050}
"""Mass of the arm by its length [kg]."""
PENDULUM = """<mujoco model="{name}">
  <compiler angle="radian"/>
  <!-- joint and servo: {origin} -->
  <default>
    <joint frictionloss="0.1" armature="{armature}"/>
    <position kp="50" dampratio="1"{limit}/>
  </default>
  <worldbody>
    <body name="pendulum">
      <inertial mass="{mass}" pos="0 0 {center}" diaginertia="{inertia} {inertia} 0.0002"/>
      <joint name="pivot" axis="0 1 0" range="-3.2 3.2"/>
      <site name="flange" pos="0 0 {length}"/>
    </body>
  </worldbody>
  <actuator><position name="pivot" joint="pivot"/></actuator>
</mujoco>
"""
FEETECH = {
    "name": "sts3215", "origin": "class so_arm100 of mujoco_menagerie's trs_so_arm100", "armature": 0.1,
    "limit": ' forcerange="-3.5 3.5"',
}  # fmt: skip
DYNAMIXEL = {
    "name": "xl330", "origin": "class dynamixel_2r of mujoco_menagerie's dynamixel_2r", "armature": 0.005,
    "limit": "",
}  # fmt: skip
SO101 = ("Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll", "Jaw")
GO2 = tuple(f"{leg}_{joint}" for leg in ("FL", "FR", "RL", "RR") for joint in ("hip", "thigh", "calf"))
GO2_LAW = (20.0, 1.5)
"""Stiffness and damping of the law of the publisher's controller [N m/rad, N m s/rad]."""


@dataclass(frozen=True)
class Recorded:
    """Recordings of an arm, and the file that a user has of it."""

    name: str  # Name of the arm
    folder: str  # Folder of its recordings
    fitted: tuple[str, ...]  # Runs that are fitted; "[a:b]" after a name is the part from a to b, in thirds
    held_out: tuple[str, ...]  # Runs by which exidyn decides
    judges: tuple[str, ...] = ()  # Runs that judge; by default those held out, where there are no others
    mjcf: str = ""  # File of the arm, below the folder of data; empty if `text` has it
    text: str = ""  # Text of the file
    commands: str = TORQUE  # What drives the simulation, `POSITION` or `TORQUE`
    gain: tuple[float, ...] = ()  # Drive gains; empty where torque was logged, or nothing [N m per unit]
    joints: tuple[str, ...] = ()  # Names of the joints that move; empty for all
    columns: Mapping[str, Any] = field(default_factory=dict)  # Options of the import


def pendulum(mass: float, length: float, arm: float, servo: Mapping[str, Any]) -> str:
    """A point mass [kg] on an arm of a length [m] and a mass [kg], with the joint and servo of a class."""
    total = mass + arm
    center = (mass + 0.5 * arm) * length / total
    inertia = mass * length**2 + arm * length**2 / 3.0 - total * center**2
    return PENDULUM.format(**servo, mass=total, center=-center, inertia=max(inertia, 1e-4), length=-length)


def with_servos(text: str, stiffness: float, damping: float) -> str:
    """A file with the position servos of a controller in place of its motors, of the same limits."""
    spec = mujoco.MjSpec.from_string(text)
    for motor in spec.actuators:
        limits = list(motor.ctrlrange)
        motor.set_to_position(kp=stiffness, kv=damping)
        motor.ctrllimited, motor.forcelimited, motor.forcerange = False, True, limits
    spec.compile()
    return str(spec.to_xml())


def by_joint(position: Sequence[str]) -> dict[str, Any]:
    """Options of the import of a log whose columns are q_NAME and cmd_NAME, without effort."""
    columns = {
        "position": [f"q_{name}" for name in position],
        "command": [f"cmd_{name}" for name in position],
    }
    return {"effort": "command", "columns": columns}


def _feetech(mass: int, length: int) -> Recorded:
    """The Feetech servo with a known mass on a known arm."""
    run = f"m{mass}_l{length}_{{}}_kp{{}}".format
    return Recorded(
        f"STS3215, {mass} g at {length} mm", "kscale_sts3215",
        (run("sin_sin", 16), run("sin_time_square", 16), run("up_and_down", 16)), (run("sin_sin", 24),),
        text=pendulum(1e-3 * mass, 1e-3 * length, ARM_MASS[length], FEETECH), gain=(SERVO_GAIN,),
    )  # fmt: skip


SERVOS = tuple(_feetech(*size) for size in PENDULUMS)
XL330 = Recorded(
    "XL330", "bam_xl330", ("kp200_sin_sin",), ("kp200_sin_time_square",), ("kp200_up_and_down",),
    text=pendulum(0.49, 0.1, 0.0, DYNAMIXEL), commands=POSITION, columns={"effort": "command"},
)  # fmt: skip
ARMS = (
    XL330,
    Recorded(
        "SO-101", "sage_so101", ("multisine", "large_amplitude"), ("lissajous_pattern",),
        ("chirp_sweep", "figure_eight", "friction_gravity", "step_response"), mjcf="sage_so101/so101.xml",
        commands=POSITION, columns=by_joint(SO101),
    ),
    Recorded(
        "Go2 legs", "go2_legs", ("legs[0:1]",), ("legs[1:2]",), ("legs[2:3]",), mjcf="go2_legs/go2.xml",
        commands=POSITION, joints=tuple(f"{name}_joint" for name in GO2), columns=by_joint(GO2),
    ),
    Recorded(
        "UR10e", "ur10e_mamedov", ("id_ur-20_02_10-30sec_12harm",), ("id_ur-20_02_12-50sec_12harm",),
        ("id_ur-20_02_05-20sec_12harm",), mjcf="mjcf/ur10e.xml", gain=tuple(DE_LUCA),
    ),
    Recorded(
        "Panda", "panda_gaz", ("traj1[0:2]",), ("traj1[2:3]",), mjcf="mjcf/panda_nohand.xml",
    ),
)  # fmt: skip


ANSWERS, LEFT = ("original", "file", "attached"), ("left_file", "left_attached")


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """Errors of every arm with every answer; the quick run has two pendulums."""
    chosen = (SERVOS[0], XL330) if quick else (*SERVOS, *ARMS)
    by_arm = {
        arm.name: kept.of(f"recorded, {arm.name}", lambda arm=arm: answered(arm, folder)) for arm in chosen
    }
    _show(by_arm)
    if RIVAL and not quick:
        show_rival(folder / "sage_so101", ARMS[1])
    judged = [arm for arm in by_arm.values() if "refused" not in arm]
    return {
        "recorded_refused": len(by_arm) - len(judged),
        "recorded_joints": sum(arm["joints"] for arm in judged),
        **{f"recorded_worse_{key}": sum(arm[f"worse_{key}"] for arm in judged) for key in ANSWERS[1:]},
        **{
            f"recorded_left_{key}": float(np.median([arm[f"left_{key}"] for arm in judged] or [np.nan]))
            for key in ANSWERS[1:]
        },
        "recorded": by_arm,
    }


RIVAL = os.environ.get("EXIDYN_RIVAL", "")
"""Script that fits only servos by simulation, MODEL --fit LOG... --test LOG... --columns COLUMN=JOINT..."""


def show_rival(folder: Path, arm: Recorded) -> None:
    """Run the rival on the same runs of an arm, which prints its errors."""
    fitted, judges = ([folder / f"{name}.csv.gz" for name in names] for names in (arm.fitted, arm.judges))
    joints = [actuator.target for actuator in mujoco.MjSpec.from_file(str(folder / "so101.xml")).actuators]
    pairs = map("=".join, zip(SO101, joints, strict=True))
    command = [RIVAL, folder / "so101.xml", "--fit", *fitted, "--test", *judges, "--columns", *pairs]
    subprocess.run([sys.executable, *map(str, command)], check=True)


def _show(by_arm: dict[str, Any]) -> None:
    head = ["arm", *(f"{when} {answer}" for when in ("0.1 s", "0.5 s", "2 s") for answer in ANSWERS)]
    rows = []
    for name, arm in by_arm.items():
        errors = np.full((3, 3), np.nan)
        if "refused" in arm:
            print(f"  {name} was refused: {arm['refused']}")
        else:
            errors[:] = 1e3 * np.array([arm[f"tool_{answer}"] for answer in ANSWERS]).T
        rows.append([name, *errors.ravel()])
    show("Real recordings: tool point [mm]", head, rows)


def answered(arm: Recorded, folder: Path) -> dict[str, Any]:
    """Errors of joints and tool point with every answer; the message of an arm that is refused."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "arm.xml"
        path.write_text(_text(arm, folder))
        try:
            errors = _errors(arm, folder / arm.folder, path)
            figures = _compared(errors)
        except Exception as error:
            figures = {"refused": f"{type(error).__name__}: {error}"}
    return figures | {"cpu_seconds": time.process_time() - began}


def _text(arm: Recorded, folder: Path) -> str:
    """Text of the file; legs, which have motors, follow positions by the law of their controller."""
    text = arm.text or (folder / arm.mjcf).read_text()
    return with_servos(text, *GO2_LAW) if "<motor" in text else text


def _errors(arm: Recorded, folder: Path, path: Path) -> tuple[list[Distances], np.ndarray]:
    """Distances with every answer, and the noise of encoders, shape (n,) [rad]."""
    model = read_model(path, arm.joints or None)
    if arm.gain:
        model = replace(model, robot=replace(model.robot, drive_gain=np.array(arm.gain)))
    roles = (("identify", arm.fitted), (HELD_OUT, arm.held_out))
    recordings = [(role, _run(arm, folder, name, model)) for role, names in roles for name in names]
    source = Source(path.read_bytes(), str(path.parent), path.name)
    answer = said(gap(source, model, recordings, arm.commands), path.read_text())
    runs = [Run.of(_run(arm, folder, name, model), Filtering()) for name in arm.judges or arm.held_out]
    simulations = ((source.text, model, False), (answer.file, answer.arm, False))
    simulations += ((answer.attached, answer.arm, answer.attaches),)
    trial = Trial(source, model, runs, answer.commands, answer.held)
    errors = [trial.distances(text, of, attach) for text, of, attach in simulations]
    return errors, np.max([run.noise for run in runs], axis=0)


def _compared(errors: tuple[list[Distances], np.ndarray]) -> dict[str, Any]:
    """Figures of three distances; a joint is worse if its error has grown by more than encoder noise."""
    (original, *answers), noise = errors
    rows, every = original.telling, np.arange(len(noise))
    before = original.joints[rows, every]
    figures = {"joints": len(noise), "tool_original": original.tool, "joints_original": original.joints}
    for key, answer in zip(ANSWERS[1:], answers, strict=True):
        after = answer.joints[rows, every]
        figures |= {
            f"tool_{key}": answer.tool, f"joints_{key}": answer.joints,
            f"worse_{key}": int(np.sum(after > before + noise)),
            f"left_{key}": float(np.median(after / before)),
        }  # fmt: skip
    return figures


def _run(arm: Recorded, folder: Path, name: str, model: Model) -> Recording:
    """A run of a log, or a part of it."""
    stem, _, part = name.partition("[")
    (run,) = import_source(folder / f"{stem}.csv.gz", model, **arm.columns)
    if not part:
        return replace(run, name=name)
    first, stop = map(int, part.rstrip("]").split(":"))
    return piece(run, first, stop, 3, name)
