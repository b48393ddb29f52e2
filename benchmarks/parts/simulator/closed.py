"""The gap between MuJoCo as the real arm, with physics concealed, and the simulation by its file.

Logs hold the motors' torque; or, as those of position servos, commands and positions alone.
"""

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from common import Kept, show

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.in_mujoco.gap import Gap, gap
from exidyn.identification.in_mujoco.ladder import Source
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.recordings.servo_error import LAW, servo_of, servo_words, with_servo_error

from .arms import MODELS, cases
from .concealed import Case, record

SECONDS = 20.0
"""Of each run."""
QUICK = 0.6
"""Share of that in a quick run."""
COMMANDS = "commands"
LOGS = ("torque", COMMANDS)


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """Figures of all arms and both kinds of log; the quick run has one arm of each kind."""
    chosen = [*cases(folder / "mjcf", ("dynamixel_2r",) if quick else MODELS)]
    pairs = [(case, log) for log in LOGS for case in chosen]
    if quick:
        pairs = [(chosen[2], "torque"), (chosen[1], COMMANDS), (chosen[0], COMMANDS)]
    seconds = SECONDS * QUICK if quick else SECONDS
    found = {
        f"{case.name}, {log}": kept.of(
            f"{case.name}, {log}, {seconds:g} s", lambda case=case, log=log: answered(case, log, seconds)
        )
        for case, log in pairs
    }
    _show(found)
    logs = {log: _summary([one for name, one in found.items() if name.endswith(log)]) for log in LOGS}
    return {**_summary([*found.values()]), "by_log": logs, "by_arm": found}


def answered(case: Case, log: str, seconds: float) -> dict[str, Any]:
    """What is found of one arm, and what it closes."""
    began = time.process_time()
    found = closed(case, log, seconds)
    findings = {(one.effect, joint) for one in found.diagnosis.findings for joint in one.joints or (-1,)}
    before, after = (1e3 * float(one.tool[-1]) for one in (found.before, found.after))
    concealed = set(case.concealed)
    return {
        "concealed": sorted(concealed),
        "named": sorted(findings & concealed),
        "false": sorted(findings - concealed),
        "undecided": sorted((one.effect, *one.joints) for one in found.diagnosis.undecided),
        "before_mm": before,
        "after_mm": after,
        "gap_left": after / before,
        "worse": int(np.sum(found.after.joints[-1] > found.before.joints[-1] + 1e-4)),
        "suspected": bool(found.diagnosis.suspicions),
        "cpu_seconds": time.process_time() - began,
    }


def closed(case: Case, log: str, seconds: float) -> Gap:
    """The gap of one arm, by position commands."""
    runs = [
        (role, record(case, seconds, seed, role)) for seed, role in enumerate(("identify", "slow", HELD_OUT))
    ]
    if log == COMMANDS:
        runs = [(role, commands_alone(run)) for role, run in runs]
    source = Source(case.path.read_bytes(), str(case.path.parent), case.path.name)
    return gap(source, case.nominal, runs)


def commands_alone(run: Recording) -> Recording:
    """The log as `exidyn import --effort command` reads one without torque."""
    servo = servo_of(run.robot, None, None)
    signals = with_servo_error(run.signals, servo, run.name)
    return replace(run, signals=signals, settings=dict(run.settings) | {LAW: servo_words(servo)})


def _show(found: dict[str, Any]) -> None:
    rows = [
        [name, len(one["concealed"]), len(one["named"]), len(one["false"]), one["before_mm"], one["after_mm"]]
        for name, one in found.items()
    ]
    head = ["arm, log", "concealed", "named", "false", "mm after 2 s", "with what was found"]
    show("MuJoCo as the real arm", head, rows)


def _summary(every: list[dict[str, Any]]) -> dict[str, Any]:
    if not every:
        return {"arms": 0}
    concealed = sum(len(one["concealed"]) for one in every)
    return {
        "arms": len(every),
        "concealed": concealed,
        "named": sum(len(one["named"]) for one in every) / max(concealed, 1),
        "false": sum(len(one["false"]) for one in every),
        "gap_left": float(np.median([one["gap_left"] for one in every])),
        "worse": sum(one["worse"] for one in every),
        "suspected": sum(one["suspected"] for one in every),
    }
