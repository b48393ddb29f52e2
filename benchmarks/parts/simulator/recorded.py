"""Real recordings, with models that users have as the nominal: how far simulation is off before and after.

What was measured drives the simulation, current by drive gains or torque, since none of these logs has
commands that a servo of the file would follow. Errors are those of `exidyn gap`, on recordings that are not
fitted.
"""

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from common import Kept, show

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.in_mujoco.gap import Gap, gap
from exidyn.identification.in_mujoco.ladder import Source
from exidyn.identification.in_mujoco.replay import TORQUE
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model
from parts.real.data import DE_LUCA, piece

SERVO_GAIN = 0.53
"""Of the Feetech servo, by known masses [N m/V]; see its KNOWN.md."""
PENDULUMS = ((535, 100), (741, 150), (969, 100), (1168, 150))
"""Mass [g] and arm [mm]."""
ARM_MASS = {100: 0.036, 150: 0.050}
"""Of the arm that carries it [kg]."""
PENDULUM = """<mujoco model="sts3215">
  <compiler angle="radian"/>
  <!-- joint and servo: class so_arm100 of mujoco_menagerie's trs_so_arm100 -->
  <default>
    <joint frictionloss="0.1" armature="0.1"/>
    <position kp="50" dampratio="1" forcerange="-3.5 3.5"/>
  </default>
  <worldbody>
    <body name="pendulum">
      <inertial mass="{mass}" pos="0 0 {centre}" diaginertia="{inertia} {inertia} 0.0002"/>
      <joint name="pivot" axis="0 1 0" range="-3.2 3.2"/>
      <site name="flange" pos="0 0 {length}"/>
    </body>
  </worldbody>
  <actuator><position name="pivot" joint="pivot"/></actuator>
</mujoco>
"""


@dataclass(frozen=True)
class Recorded:
    """Recordings of an arm, and the file that a user has of it.

    Attributes:
        name: Of the arm.
        folder: Of its recordings.
        mjcf: File of Menagerie's; empty for a text.
        fitted: Runs; "[a:b]" behind one is the part from a to b, in thirds.
        held_out: Those that judge.
        gain: Drive gains; empty where torque was logged [N m per unit].
        text: The file, where it is none of Menagerie's.
    """

    name: str
    folder: str
    mjcf: str
    fitted: tuple[str, ...]
    held_out: tuple[str, ...]
    gain: tuple[float, ...] = ()
    text: str = ""


def _pendulum(mass: int, length: int) -> Recorded:
    """The servo with a known mass on a known arm, joint and servo as Menagerie's SO-ARM100 has them."""
    point, arm, end = 1e-3 * mass, ARM_MASS[length], 1e-3 * length
    whole = point + arm
    centre = (point + 0.5 * arm) * end / whole
    inertia = point * end**2 + arm * end**2 / 3.0 - whole * centre**2
    text = PENDULUM.format(mass=whole, centre=-centre, inertia=max(inertia, 1e-4), length=-end)
    run = f"m{mass}_l{length}_{{}}_kp{{}}".format
    return Recorded(
        f"STS3215, {mass} g at {length} mm", "kscale_sts3215", "",
        (run("sin_sin", 16), run("sin_time_square", 16), run("up_and_down", 16)), (run("sin_sin", 24),),
        (SERVO_GAIN,), text,
    )  # fmt: skip


SERVOS = tuple(_pendulum(*one) for one in PENDULUMS)
ARMS = (
    Recorded(
        "UR10e", "ur10e_mamedov", "ur10e.xml", ("id_ur-20_02_10-30sec_12harm",),
        ("id_ur-20_02_12-50sec_12harm",), tuple(DE_LUCA),
    ),
    Recorded("Panda", "panda_gaz", "panda_nohand.xml", ("traj1[0:2]",), ("traj1[2:3]",)),
)  # fmt: skip


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """Errors of every arm before and after; the quick run has one pendulum."""
    chosen = SERVOS[:1] if quick else (*SERVOS, *ARMS)
    found = {
        one.name: kept.of(f"recorded, {one.name}", lambda one=one: answered(one, folder)) for one in chosen
    }
    rows = [
        [name, *_pairs(one["tool_before"], one["tool_after"]), f"{one['joints_worse']} of {one['joints']}"]
        for name, one in found.items()
    ]
    times = [f"{when} {what}" for when in ("0.1 s", "0.5 s", "2 s") for what in ("before", "after")]
    head = ["arm", *times, "worse"]
    show("Real recordings held out: tool point [mm]", head, rows)
    return {
        "recorded_worse": sum(one["joints_worse"] for one in found.values()),
        "recorded_joints": sum(one["joints"] for one in found.values()),
        "recorded_error_left": float(np.median([one["error_left"] for one in found.values()])),
        "recorded": found,
    }


def _pairs(before: Sequence[float], after: Sequence[float]) -> list[float]:
    """Both after each horizon [mm]."""
    return [1e3 * value for pair in zip(before, after, strict=True) for value in pair]


def answered(one: Recorded, folder: Path) -> dict[str, Any]:
    """Errors before and after, of joints and tool point."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as scratch:
        path = folder / "mjcf" / one.mjcf if one.mjcf else Path(scratch) / "arm.xml"
        if one.text:
            path.write_text(one.text)
        found = _gap(one, folder / one.folder, path)
    before, after, telling = found.before, found.after, found.before.telling
    worse = after.joints > before.joints + np.max([run.noise for run in found.runs], axis=0)
    every = np.arange(len(telling))
    return {
        "horizons": list(found.horizons),
        "joints": len(telling),
        "joints_before": before.joints.tolist(),
        "joints_after": after.joints.tolist(),
        "tool_before": before.tool.tolist(),
        "tool_after": after.tool.tolist(),
        "joints_worse": int(worse[telling, every].sum()),
        "worse_after_each": worse.sum(axis=1).tolist(),
        "telling": [float(found.horizons[place]) for place in telling],
        "error_left": float(np.median(after.joints[telling, every] / before.joints[telling, every])),
        "stages": [[stage.name, stage.reason] for stage in found.stages],
        "taken_out": list(found.taken_out),
        "beyond": list(found.beyond),
        "suspected": list(found.diagnosis.suspicions),
        "cpu_seconds": time.process_time() - began,
    }


def _gap(one: Recorded, folder: Path, path: Path) -> Gap:
    """The gap."""
    model = read_model(path)
    if one.gain:
        model = replace(model, robot=replace(model.robot, drive_gain=np.array(one.gain)))
    runs = [
        (role, _run(folder, name, model))
        for role, names in (("identify", one.fitted), (HELD_OUT, one.held_out))
        for name in names
    ]
    return gap(Source(path.read_bytes(), str(path.parent), path.name), model, runs, TORQUE)


def _run(folder: Path, name: str, model: Any) -> Recording:
    stem, _, part = name.partition("[")
    (run,) = import_source(folder / f"{stem}.csv.gz", model)
    if not part:
        return replace(run, name=name)
    first, stop = map(int, part.rstrip("]").split(":"))
    return piece(run, first, stop, 3, name)
