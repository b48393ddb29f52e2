"""The gap between plain MuJoCo as the real arm and the simulation by its file, judged on a third motion.

exidyn is given two motions: it fits the first and decides by the second. The third judges both answers: the
file by the benchmark's own rollouts, and the file with effects attached by exidyn's simulator.
"""

import time
from typing import Any

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.in_mujoco.gap import gap
from exidyn.identification.in_mujoco.replay import POSITION, Run
from exidyn.identification.in_mujoco.trial import Source, Trial
from exidyn.identification.preparation.prepare import Filtering

from .answers import Said, said
from .arms import TORQUE, Arm
from .judge import tool_error
from .motions import SEEDS, logged, moved
from .real_arm import Motion, interpolated
from .score import score

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
