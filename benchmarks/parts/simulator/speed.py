"""What effects cost in MuJoCo's steps: process time beside that of the model alone, within one run."""

import time
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import mujoco
from common import Kept, show

from exidyn.identification.in_mujoco.attached import Attached
from exidyn.identification.robot_files.mjcf_drives import servos

from .concealed import STEP, Case
from .effect_arms import cases

STEPS, ROUNDS = 1000, 5
"""Steps of a round, and rounds in turn, of which the fastest counts: other programs only slow one down."""


class Cost(NamedTuple):
    """Of one arm."""

    plain: float  # Process time of a step of the model alone [us]
    attached: float  # With the effects

    @property
    def speed(self) -> float:
        """Steps a second over those of the model alone [-]."""
        return self.plain / self.attached


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """Steps a second with effects over those of plain MuJoCo; the effects are those of the cases."""
    chosen = cases(folder / "mjcf", ("dynamixel_2r",)) if quick else cases(folder / "mjcf")
    costs = {case.name: cost(case) for case in chosen}
    rows = [[name, one.plain, one.attached, one.speed] for name, one in costs.items()]
    show("A step of MuJoCo's", ["arm", "plain [us]", "with effects [us]", "speed"], rows)
    every = [one.speed for one in costs.values()]
    return {"speed": median(every), "slowest": min(every)}


def cost(case: Case) -> Cost:
    """Of an arm that its servos move to a pose."""
    model = mujoco.MjModel.from_xml_path(str(case.path))
    model.opt.timestep, model.opt.integrator = STEP, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data, motors = mujoco.MjData(model), servos(model, case.nominal.robot.joints)
    fastest = {"plain": float("inf"), "attached": float("inf")}
    for _ in range(ROUNDS):
        fastest["plain"] = min(fastest["plain"], _seconds(model, data, motors))
        with Attached(model, data, case.real):
            fastest["attached"] = min(fastest["attached"], _seconds(model, data, motors))
    return Cost(**{name: 1e6 * seconds / STEPS for name, seconds in fastest.items()})


def _seconds(model: mujoco.MjModel, data: mujoco.MjData, motors: list[int]) -> float:
    mujoco.mj_resetData(model, data)
    data.ctrl[motors] = 0.3
    mujoco.mj_step(model, data)  # what is new to the effects is told to them
    begun = time.process_time()
    mujoco.mj_step(model, data, STEPS)
    return time.process_time() - begun
