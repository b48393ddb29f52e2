"""What effects cost in MuJoCo's steps: process time beside that of the model alone, within one run."""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any
from zlib import crc32

import mujoco
import numpy as np
from common import Kept, show

from exidyn.identification.effects import (
    Effect,
    FrictionAsymmetry,
    Hysteresis,
    LoadDependentFriction,
    Prior,
    StribeckFriction,
)
from exidyn.identification.in_mujoco.attached import Attached
from exidyn.identification.model import Model
from exidyn.identification.robot_files.mjcf_drives import servos
from exidyn.trajectories.random_motion import random_fourier

from .concealed import STEP, Case, described, with_effects

MODELS = ("dynamixel_2r", "ur10e", "so_arm100", "panda_nohand", "piper", "iiwa14")
ARMS = 3
"""Of each model; one of them has nothing concealed."""
COULOMB = (0.05, 0.15)
"""Of each joint, over its rms torque; the file's own stays, if that is more."""

Concealed = Callable[[str, float, np.random.Generator], tuple[Effect, float]]
"""An effect of a joint with the value of its parameter, for an rms torque of the joint [N m]."""

PHYSICS: dict[str, Concealed] = {
    "stribeck_friction": lambda joint, torque, draw: (
        StribeckFriction((joint,), fade=draw.uniform(0.08, 0.2)), draw.uniform(0.15, 0.3) * torque,
    ),
    "load_dependent_friction": lambda joint, torque, draw: (
        LoadDependentFriction((joint,)), draw.uniform(0.1, 0.2),
    ),
    "friction_asymmetry": lambda joint, torque, draw: (
        FrictionAsymmetry((joint,), viscous=True), draw.uniform(0.05, 0.1) * torque,
    ),
    "hysteresis": lambda joint, torque, draw: (
        Hysteresis((joint,), presliding=draw.uniform(2e-3, 1e-2)), draw.uniform(0.15, 0.3) * torque,
    ),
}  # fmt: skip
"""Name -> how it is drawn: a third of a joint's torque at most, so that no arm is absurd.

Drag differs by direction too. With dry friction alone the effect is a constant torque, which every fit has,
but for rest and its neighbourhood: of the samples above 10 mrad/s in three of these logs all that tells them
apart is a log-likelihood of 0.02, and of slower ones friction has no law.
"""


def cases(folder: Path, models: tuple[str, ...] = MODELS, arms: int = ARMS) -> Iterator[Case]:
    """Real arms, the same ones each time."""
    for name in models:
        path = folder / f"{name}.xml"
        nominal = described(path)
        for number in range(arms):
            # The first has nothing concealed, the others one effect and two.
            yield _case(f"{name} {number + 1}", path, nominal, number)


def _case(name: str, path: Path, nominal: Model, count: int) -> Case:
    draw = np.random.default_rng(crc32(name.encode()))
    torque, joints = usual_torque(nominal), nominal.robot.joints
    real = _with_friction(nominal, draw.uniform(*COULOMB, len(joints)) * torque)
    concealed = []
    for joint in draw.permutation(len(joints))[:count]:
        # Friction by load is nothing where there is none.
        names = [one for one in PHYSICS if one != "load_dependent_friction" or _bears(nominal, int(joint))]
        effect = str(draw.choice(names))
        real = with_effects(real, PHYSICS[effect](joints[joint], float(torque[joint]), draw))
        concealed.append((effect, int(joint)))
    return Case(name, path, nominal, real, tuple(concealed))


def _with_friction(model: Model, dry: np.ndarray) -> Model:
    stated = dict(model.stated)
    for joint, value in enumerate(dry):
        name = f"Fc{joint + 1}"
        stated[name] = Prior(max(float(value), stated[name].value if name in stated else 0.0))
    return replace(model, stated=stated)


def usual_torque(model: Model) -> np.ndarray:
    """Rms torque of each joint in random motion, shape (n,) [N m]."""
    motion = random_fourier(model.robot.limits, 10.0, seed=0).at(np.arange(0.0, 10.0, 0.05))
    return np.asarray(np.sqrt(np.mean(model.torque(motion, model.nominal_values) ** 2, axis=0)))


def _bears(model: Model, joint: int) -> bool:
    """Whether gears of a joint carry a load that changes: half of its torque."""
    motion = random_fourier(model.robot.limits, 10.0, seed=0).at(np.arange(0.0, 10.0, 0.05))
    bodies = replace(model, effects=tuple(one for one in model.effects if one.of_links), stated={})
    load = bodies.torque(motion, bodies.nominal_values)[:, joint]
    return bool(np.sqrt(np.mean(load**2)) > 0.5 * usual_torque(model)[joint])


STEPS, ROUNDS = 1000, 5
"""Steps of a round, and rounds in turn, of which the fastest counts: other programs only slow one down."""


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """Steps a second with effects over those of plain MuJoCo; the effects are those of the cases."""
    chosen = cases(folder / "mjcf", ("dynamixel_2r",)) if quick else cases(folder / "mjcf")
    rows = [[case.name, *costs(case)] for case in chosen]
    rows = [[*row, row[1] / row[2]] for row in rows]
    show("A step of MuJoCo's", ["arm", "plain [us]", "with effects [us]", "speed"], rows)
    ratios = [row[3] for row in rows]
    return {"speed": median(ratios), "slowest": min(ratios)}


def costs(case: Case) -> tuple[float, float]:
    """Process time of a step of an arm that its servos move to a pose, alone and with effects [us]."""
    model = mujoco.MjModel.from_xml_path(str(case.path))
    model.opt.timestep, model.opt.integrator = STEP, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data, motors = mujoco.MjData(model), servos(model, case.nominal.robot.joints)
    plain, attached = [], []
    for _ in range(ROUNDS):
        plain.append(_seconds(model, data, motors))
        with Attached(model, data, case.real):
            attached.append(_seconds(model, data, motors))
    return 1e6 * min(plain) / STEPS, 1e6 * min(attached) / STEPS


def _seconds(model: mujoco.MjModel, data: mujoco.MjData, motors: list[int]) -> float:
    mujoco.mj_resetData(model, data)
    data.ctrl[motors] = 0.3
    mujoco.mj_step(model, data)  # what is new to the effects is told to them
    begun = time.process_time()
    mujoco.mj_step(model, data, STEPS)
    return time.process_time() - begun
