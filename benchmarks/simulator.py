"""Arms from MJCF: torque beside MuJoCo's own, and the gap between simulation and arms that have more.

`EXIDYN_DATA` names the folder of data, with models in `mjcf`. `round_trip` is the largest difference of a
joint's torque over the largest torque, in random motion, without dry friction, a constraint in MuJoCo.

Real arms are MuJoCo's own, in which friction and other physics are concealed that the file does not have.
`named` is the share of concealed effects that are found on their joint, `false` a count of others, `gap_left`
the median of the tool point's error after 2 s of commands, after over before; `worse` counts joints that are
farther off than by the file as it was; `refused` logs that the check of units and signs holds for wrong.

`speed` is the median of steps a second with these effects attached over those of plain MuJoCo, by process
time within one run; `slowest` that of the slowest arm. Plain MuJoCo has the file's own dry friction, a
constraint, in place of the effects': where a file has some, effects may cost less than that.
"""

import os
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: matrices are small

import mujoco
import numpy as np
from common import parser, save, show
from parts.simulator.arms import cases
from parts.simulator.concealed import Case, read_hinges, record
from parts.simulator.speed import cost

from exidyn.identify.arm.motion import Motion
from exidyn.identify.diagnosis.runs.usable import HELD_OUT
from exidyn.identify.errors import WrongInput
from exidyn.identify.in_mujoco.gap import Gap, Source, gap

SAMPLES = 200
SECONDS = 20.0
"""Of each run."""


def round_trip(path: Path, samples: int) -> float:
    """Largest difference of torque over the largest one [-]; joints that slide are held, as fingers are."""
    compiled, model = read_hinges(path)
    joints = model.robot.joints
    draw = np.random.default_rng(0).uniform(-2.0, 2.0, (3, samples, len(joints)))
    values = model.nominal_values
    values[[name.startswith("Fc") for name in model.names]] = 0.0
    ours = model.torque(Motion.of(np.arange(samples) * 0.01, *draw), values)
    compiled.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data, theirs = mujoco.MjData(compiled), np.empty_like(ours)
    dofs = [int(compiled.joint(name).dofadr[0]) for name in joints]
    for row, (position, velocity, acceleration) in enumerate(zip(*draw, strict=True)):
        data.qpos[:] = compiled.qpos0
        data.qpos[dofs], data.qvel[dofs], data.qacc[dofs] = position, velocity, acceleration
        mujoco.mj_inverse(compiled, data)
        theirs[row] = data.qfrc_inverse[dofs]
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


def closed(case: Case, seconds: float) -> tuple[Gap, bool]:
    """The gap of one arm, by position commands; and whether its logs were refused at first."""
    runs = [
        (role, record(case, seconds, seed, role)) for seed, role in enumerate(("identify", "slow", HELD_OUT))
    ]
    source = Source(case.path.read_bytes(), str(case.path.parent), case.path.name)
    for refused in (False, True):
        try:
            return gap(source, case.nominal, runs, as_recorded=refused), refused
        except WrongInput as error:
            print(f"  {case.name}: {error}")
    raise AssertionError("as recorded, nothing is refused")


def concealed(folder: Path, quick: bool) -> dict[str, Any]:
    """Figures of all arms with concealed physics."""
    chosen = cases(folder, ("dynamixel_2r",)) if quick else cases(folder)
    by_arm: dict[str, Any] = {}
    for case in chosen:
        found, refused = closed(case, 0.6 * SECONDS if quick else SECONDS)
        findings = {(one.effect, joint) for one in found.diagnosis.findings for joint in one.joints or (-1,)}
        before, after = (1e3 * float(one.tool[-1]) for one in (found.before, found.after))
        by_arm[case.name] = {
            "concealed": case.concealed,
            "named": sorted(findings & set(case.concealed)),
            "false": sorted(findings - set(case.concealed)),
            "before_mm": before,
            "after_mm": after,
            "gap_left": after / before,
            "worse": int(np.sum(found.after.joints[-1] > found.before.joints[-1] + 1e-4)),
            "refused": refused,
        }
        print(f"  {case.name}: {by_arm[case.name]}", flush=True)
    rows = [
        [name, len(one["concealed"]), len(one["named"]), len(one["false"]), one["before_mm"], one["after_mm"]]
        for name, one in by_arm.items()
    ]
    head = ["arm", "concealed", "named", "false", "mm after 2 s", "with what was found"]
    show("MuJoCo as the real arm", head, rows)
    every = list(by_arm.values())
    return {
        "arms": len(every),
        "named": sum(len(one["named"]) for one in every)
        / max(sum(len(one["concealed"]) for one in every), 1),
        "false": sum(len(one["false"]) for one in every),
        "gap_left": float(np.median([one["gap_left"] for one in every])),
        "worse": sum(one["worse"] for one in every),
        "refused": sum(one["refused"] for one in every),
        "by_arm": by_arm,
    }


def speed(folder: Path, quick: bool) -> dict[str, Any]:
    """Steps a second with effects over those of plain MuJoCo; the effects are those of the real arms."""
    chosen = cases(folder, ("dynamixel_2r", "ur10e")) if quick else cases(folder)
    costs = {case.name: cost(case) for case in chosen}
    rows = [[name, one.plain, one.attached, one.speed] for name, one in costs.items()]
    show("A step of MuJoCo's", ["arm", "plain [us]", "with effects [us]", "speed"], rows)
    every = [one.speed for one in costs.values()]
    return {"speed": float(np.median(every)), "slowest": min(every)}


def main() -> None:
    given = parser(__doc__.splitlines()[0], ("round_trip", "concealed", "speed")).parse_args()
    folder = Path(os.environ.get("EXIDYN_DATA", "")) / "mjcf"
    files = sorted(folder.glob("*.xml"))
    if not files:
        raise SystemExit("no models: EXIDYN_DATA names no folder with mjcf/*.xml")
    figures: dict[str, Any] = {}
    if not given.only or "round_trip" in given.only:
        errors = {path.stem: round_trip(path, SAMPLES // 10 if given.quick else SAMPLES) for path in files}
        show("Torque beside mj_inverse", ["model", "largest difference"], [*errors.items()])
        figures |= {"models": len(errors), "round_trip": max(errors.values()), "by_model": errors}
    if not given.only or "concealed" in given.only:
        figures |= concealed(folder, given.quick)
    if not given.only or "speed" in given.only:
        figures |= speed(folder, given.quick)
    save(given.json, figures)


if __name__ == "__main__":
    main()
