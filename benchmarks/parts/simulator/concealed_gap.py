"""The gap between plain MuJoCo as the real arm and the simulation by its file, before and after.

exidyn is given two motions: it fits the first and decides by the second. A third judges both answers: the
file by the benchmark's own rollouts, and the file with effects attached by exidyn's simulator. Arms with
nothing concealed are the control: every attribute that is changed there is changed for nothing.
"""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from common import Kept, show

from exidyn.identification.arm.newton_euler import flange_position
from exidyn.identification.arm.robot import Robot
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.in_mujoco.gap import gap
from exidyn.identification.in_mujoco.replay import POSITION, Run
from exidyn.identification.in_mujoco.trial import Source, Trial
from exidyn.identification.preparation.prepare import Filtering

from .arms import QUICK, SEEDS, TABLE, TORQUE, Arm, arms, logged, moved
from .real_arm import Motion, interpolated, places_of
from .score import Said, said, score

HORIZON = 2.0
"""Time after a start at which the tool points are compared [s]."""
STARTS = 24
"""Number of starts, evenly spaced."""
FAR = 10.0
"""Distance that counts for a simulation that has diverged [m]."""


def tool_error(text: str, robot: Robot, motion: Motion) -> float:
    """RMS distance between the tool points of a file's simulation and of the real arm [mm]."""
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    last = np.searchsorted(motion.time, motion.time[-1] - HORIZON - 1e-9, side="right") - 1
    rows = np.unique(np.linspace(0, last, STARTS).astype(int))
    ahead = int(round(HORIZON / (motion.time[1] - motion.time[0])))
    ends = [rolled(model, robot.joints, motion, int(row)) for row in rows]
    distances = [
        _distance(robot, end, real) for end, real in zip(ends, motion.position[rows + ahead], strict=True)
    ]
    return 1e3 * float(np.sqrt(np.mean(np.square(distances))))


def rolled(model: mujoco.MjModel, joints: Sequence[str], motion: Motion, row: int) -> np.ndarray:
    """Positions `HORIZON` after sample `row`, shape (n,) [rad]; not finite if the simulation has diverged."""
    places, data, start = places_of(model, joints), mujoco.MjData(model), motion.time[row]
    qpos, dofs, servos = ([getattr(place, name) for place in places] for name in ("qpos", "dof", "actuator"))
    data.qpos[qpos], data.qvel[dofs] = motion.position[row], motion.velocity[row]
    _remember(model, data, servos, motion, start)
    steps = start + model.opt.timestep * np.arange(round(HORIZON / model.opt.timestep))
    for control in interpolated(steps, motion.time, motion.command):
        data.ctrl[servos] = control
        mujoco.mj_step(model, data)
    return np.asarray(data.qpos[qpos])


def _remember(
    model: mujoco.MjModel, data: mujoco.MjData, servos: Sequence[int], motion: Motion, start: float
) -> None:
    """Write what was commanded before a start into the buffers of actuators with a delay."""
    for joint, servo in enumerate(servos):
        if count := int(model.actuator_history[servo, 0]):
            past = model.opt.timestep * np.arange(-count, 0)
            values = interpolated(start + past, motion.time, motion.command[:, joint : joint + 1])
            mujoco.mj_initCtrlHistory(model, data, servo, past, values)


def _distance(robot: Robot, simulated: np.ndarray, real: np.ndarray) -> float:
    """Distance between the tool points at two positions (n,) [m], at most `FAR`."""
    if not np.all(np.abs(simulated) < 1e3):
        return FAR
    data: Any = robot.kinematics.createData()
    ends = [flange_position(robot.kinematics, robot.flange, position, data) for position in (simulated, real)]
    return min(float(np.linalg.norm(ends[0] - ends[1])), FAR)


NOISE = 0.05
"""Error below which a file is no worse than another [mm]: the resolution of an encoder at the tool point."""
WORSE = 1.01
"""Factor of an error above which a file is worse."""


def answered(arm: Arm, seconds: float) -> dict[str, Any]:
    """Figures of one arm; those of an arm that is refused hold the message."""
    began, third = time.process_time(), moved(arm, seconds, SEEDS["third"])
    original = arm.path.read_text()
    robot = arm.nominal.robot
    figures = {
        "log": f"{arm.log}, {arm.rate:g} Hz",
        "concealed": [(item.kind, item.joints, item.values) for item in arm.items],
        "original_mm": tool_error(original, robot, third),
        "true_file_mm": tool_error(arm.real().text(), robot, third),
    }
    try:
        result = gap(_source(arm), arm.nominal, _given(arm, seconds))
        figures |= judged(arm, said(result, original), third, figures["original_mm"])
    except Exception as error:
        figures["refused"] = f"{type(error).__name__}: {error}"
    return figures | {"cpu_seconds": time.process_time() - began}


def judged(arm: Arm, answer: Said, third: Motion, original: float) -> dict[str, Any]:
    """Figures of an answer about an arm, whose original file has an error on its third motion [mm]."""
    scores = score(arm.items, answer, arm.log == TORQUE)
    file = tool_error(answer.file.decode(), arm.nominal.robot, third)
    attached = _attached(arm, answer, third)
    figures = {
        "named": scores.named,
        "false": scores.false,
        "file_mm": file,
        "attached_mm": attached,
        "file_worse": file > WORSE * original + NOISE,
    }
    if arm.items:
        return figures | {"gap_left_file": file / original, "gap_left_attached": attached / original}
    return figures | {"changed": sorted(answer.changed)}


def _given(arm: Arm, seconds: float) -> list[tuple[str, Any]]:
    """Logs that exidyn is given, by role."""
    roles = ("identify", HELD_OUT)
    return [(role, logged(arm, moved(arm, seconds, SEEDS[role]), SEEDS[role], role)) for role in roles]


def _attached(arm: Arm, answer: Said, third: Motion) -> float:
    """Error of the file with effects attached, by exidyn's simulator on the third motion [mm].

    A file to which nothing is attached is judged as a file: logs have commands at their own rate only.
    It starts in the states of the real arm too: those of the log would add errors of sensors.
    """
    if not answer.attaches:
        return tool_error(answer.attached.decode(), arm.nominal.robot, third)
    run = Run.of(logged(arm, third, SEEDS["third"], "third"), Filtering())
    position, velocity = (
        interpolated(run.time, third.time, values) for values in (third.position, third.velocity)
    )
    run = run._replace(position=position, velocity=velocity)
    trial = Trial(_source(arm), arm.nominal, [run], POSITION, answer.held)
    distances = trial.distances(answer.attached, answer.arm, attach=answer.attaches)
    return 1e3 * float(distances.tool[-1])


def _source(arm: Arm) -> Source:
    return Source(arm.path.read_bytes(), str(arm.path.parent), arm.path.name)


LEFT = ("gap_left_attached", "gap_left_file")
SECONDS, QUICK_SECONDS = 20.0, 10.0
"""Duration of each motion."""


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """Figures of all arms; the quick run has four small ones and shorter motions."""
    seconds = QUICK_SECONDS if quick else SECONDS
    rows = QUICK if quick else tuple(range(len(TABLE)))
    by_arm = {
        arm.name: kept.of(f"{arm.name}, {seconds:g} s", lambda arm=arm: answered(arm, seconds))
        for arm in arms(folder / "mjcf", rows)
    }
    _show(by_arm)
    return {**summary([*by_arm.values()]), "by_arm": by_arm}


def summary(every: list[dict[str, Any]]) -> dict[str, Any]:
    """Figures of several arms together; medians are NaN where no arm was judged."""
    judged = [arm for arm in every if "refused" not in arm]
    controls = [arm for arm in judged if "changed" in arm]
    concealed = sum(len(arm["concealed"]) for arm in every)
    return {
        "arms": len(every),
        "concealed": concealed,
        "named_percent": 100.0 * sum(len(arm["named"]) for arm in judged) / max(concealed, 1),
        "false": sum(len(arm["false"]) for arm in judged),
        "refused": len(every) - len(judged),
        **{key: float(np.median([arm[key] for arm in judged if key in arm] or [np.nan])) for key in LEFT},
        "file_worse_than_original": sum(arm["file_worse"] for arm in judged),
        "control_unchanged": 100.0 * float(np.mean([not arm["changed"] for arm in controls] or [np.nan])),
        "changed_for_nothing": sum(len(arm.get("changed", ())) for arm in judged),
    }


def _show(by_arm: dict[str, dict[str, Any]]) -> None:
    head = [
        "arm", "log", "concealed", "named", "false", "original", "true file", "file", "attached",
    ]  # fmt: skip
    rows = [[name, arm["log"], _words(arm), *_numbers(arm)] for name, arm in by_arm.items()]
    show("Plain MuJoCo as the real arm: tool point after 2 s on the third motion [mm]", head, rows)
    for name, arm in by_arm.items():
        if "refused" in arm:
            print(f"  {name} was refused: {arm['refused']}")


def _words(arm: dict[str, Any]) -> str:
    """What is concealed, such as "kp 1, delay all"."""
    words = []
    for kind, joints, _ in arm["concealed"]:
        where = "all" if len(joints) > 1 else " ".join(map(str, joints)) or "base"
        words.append(f"{kind} {where}")
    return ", ".join(words) or "nothing"


def _numbers(arm: dict[str, Any]) -> list[Any]:
    counts = [len(arm[key]) if key in arm else None for key in ("named", "false")]
    return [*counts, *(arm.get(key) for key in ("original_mm", "true_file_mm", "file_mm", "attached_mm"))]
