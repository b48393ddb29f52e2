"""Gears that give way, in MuJoCo as the real arm: an elastic one, and one whose teeth have play.

The real arm's second hinge and its teeth, a stiff spring on both sides, are made here by MuJoCo's MjSpec and
a callback, of which exidyn uses neither to write the file.
"""

import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from common import Kept, show

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.in_mujoco.gap import gap
from exidyn.identification.in_mujoco.trial import Source
from exidyn.identification.model import Model

from .concealed import described, recorded

ARM = """<mujoco model="two">
  <compiler angle="radian"/>
  <option timestep="0.001" integrator="implicitfast"/>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <inertial mass="{mass}" pos="0.15 0 0.02" diaginertia="0.03 0.06 0.06"/>
      <joint name="shoulder" axis="{axis}" range="-2 2" damping="{damping}" armature="0.6"
             frictionloss="{dry}"/>
      <body name="lower" pos="0.4 0 0">
        <inertial mass="2" pos="0.1 0 0.01" diaginertia="0.01 0.02 0.02"/>
        <joint name="elbow" axis="0 1 0" range="-2 2" damping="{damping}" armature="0.05"
               frictionloss="{dry}"/>
        <site name="flange" pos="0.3 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="a" joint="shoulder" kp="3000" kv="100"/>
    <position name="b" joint="elbow" kp="400" kv="15"/>
  </actuator>
</mujoco>
"""
FILE = {"mass": 4.0, "damping": 0.8, "dry": 0.5}
REAL = {"mass": 4.4, "damping": 1.1, "dry": 0.8}
"""Numbers that the file has, and the real arm."""
TEETH, TEETH_DAMPING = 45.0, 0.5
"""Resonance of the link on its teeth [Hz], and its damping ratio."""
DAMPING = 0.1
"""Damping ratio of an elastic gear."""
SECONDS = 20.0
"""Of each run."""
HORIZON = 1
"""Place of 0.5 s among the horizons: later a recording of these arms is no better known than the joint."""


class Case(NamedTuple):
    """A joint whose gear gives way."""

    joint: str  # Its name
    axis: str  # Of the shoulder
    resonance: float = 0.0  # Of the link on the gear [Hz]; 0 for a gear with play
    play: float = 0.0  # Whole width [rad]


CASES = {
    "elastic, 10 Hz": Case("shoulder", "0 1 0", resonance=10.0),
    "elastic, 7 Hz, vertical": Case("shoulder", "0 0 1", resonance=7.0),
    "play of 6 mrad": Case("shoulder", "0 0 1", play=0.006),
    "play of 2 mrad": Case("shoulder", "0 0 1", play=0.002),
}


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """Figures of all cases; the quick run has one with play."""
    chosen = list(CASES)[2:3] if quick else list(CASES)
    found = {name: kept.of(f"gears: {name}", lambda name=name: answered(CASES[name])) for name in chosen}
    rows = [
        [name, one["true"], one["written"], one["half"], *(1e3 * value for value in one["distances"])]
        for name, one in found.items()
    ]
    head = ["gear", "true", "written", "± 95 %", "mrad after 0.5 s", "with numbers", "with the gear"]
    show("Gears that give way", head, rows)
    written = [one for one in found.values() if np.isfinite(one["written"])]
    return {
        "gears": len(found),
        "gears_written": len(written),
        "gear_error": max((abs(one["written"] / one["true"] - 1.0) for one in written), default=np.nan),
        "gear_gap_left": max((one["distances"][2] / one["distances"][1] for one in written), default=np.nan),
        "by_gear": found,
    }


def answered(case: Case) -> dict[str, Any]:
    """What is written of one gear, and what it closes; NaN where nothing is.

    Distances are those of the file, with its numbers fitted, and with what is written, of the gear's joint.
    """
    began = time.process_time()
    text, real = (ARM.format(axis=case.axis, **numbers) for numbers in (FILE, REAL))
    with tempfile.TemporaryDirectory(prefix="gears-") as scratch:
        path = Path(scratch) / "two.xml"
        path.write_text(text)
        nominal = described(path)
        seeds = {"identify": 0, "slow": 5, HELD_OUT: 2}
        runs = [(role, record(case, real, nominal, seed, role)) for role, seed in seeds.items()]
        found = gap(Source(text.encode(), scratch, path.name), nominal, runs, commands="position")
    joint = nominal.robot.joints.index(case.joint)
    changes = [change for change in found.attached.changes if "_twist" in change.where]
    stages = (found.original, found.stages[0].distances or found.original, found.attached.distances)
    written = changes[0] if changes else None
    return {
        "true": case.play or stiffness(case, real),
        "written": written.new if written else np.nan,
        "half": written.half if written else np.nan,
        "distances": [float(distances.joints[HORIZON, joint]) for distances in stages],
        "cpu_seconds": time.process_time() - began,
    }


def stiffness(case: Case, text: str) -> float:
    """Of an elastic gear, or of the teeth [N m/rad]."""
    angular = 2.0 * np.pi * (case.resonance or TEETH)
    return _inertia(case, text) * angular**2


def _inertia(case: Case, text: str) -> float:
    """Of what the joint moves, where the arm is at its reference [kg m^2]."""
    model = mujoco.MjModel.from_xml_string(text)
    dof = int(model.joint(case.joint).dofadr[0])
    return float(model.dof_M0[dof] - model.dof_armature[dof])


def record(case: Case, text: str, nominal: Model, seed: int, name: str) -> Any:
    """A log of the arm with that gear."""
    spec = mujoco.MjSpec.from_string(text)
    joint = spec.joint(case.joint)
    spring = {"stiffness": 0.0, "damping": 0.0}
    if not case.play:
        loss = 2.0 * DAMPING * np.sqrt(stiffness(case, text) * _inertia(case, text))
        spring = {"stiffness": stiffness(case, text), "damping": loss}
    joint.parent.add_joint(name="hidden", type=mujoco.mjtJoint.mjJNT_HINGE, axis=joint.axis, **spring)
    model = spec.compile()
    if case.play:
        mujoco.set_mjcb_passive(_teeth(case, text, model))
    try:
        return recorded(model, mujoco.MjData(model), nominal, SECONDS, seed, name)
    finally:
        mujoco.set_mjcb_passive(None)


def _teeth(case: Case, text: str, real: mujoco.MjModel) -> Any:
    """What pushes the link back at both ends of its play, as a callback."""
    hidden = real.joint("hidden")
    place, dof = int(hidden.qposadr[0]), int(hidden.dofadr[0])
    spring = stiffness(case, text)
    loss = 2.0 * TEETH_DAMPING * np.sqrt(spring * _inertia(case, text))

    def push(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        past = data.qpos[place] - np.clip(data.qpos[place], -0.5 * case.play, 0.5 * case.play)
        if model.nv == real.nv and past:
            data.qfrc_passive[dof] -= spring * past + loss * data.qvel[dof]

    return push
