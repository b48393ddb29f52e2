"""Figures of all real arms: what is named of what is concealed, and which gap is left on the third motion.

Arms with nothing concealed are the control: every attribute that is changed there is changed for nothing.
"""

from pathlib import Path
from typing import Any

import numpy as np
from common import Kept, show

from .arms import QUICK, TABLE, arms
from .closed import answered

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
    return {**summary([*by_arm.values()]), "by_log": _by_log(by_arm), "by_arm": by_arm}


def summary(every: list[dict[str, Any]]) -> dict[str, Any]:
    """Figures of several arms together; medians are NaN where no arm was judged."""
    judged = [arm for arm in every if "refused" not in arm]
    concealed = sum(len(arm["concealed"]) for arm in every)
    return {
        "arms": len(every),
        "concealed": concealed,
        "named_percent": 100.0 * sum(len(arm["named"]) for arm in judged) / max(concealed, 1),
        "false": sum(len(arm["false"]) for arm in judged),
        "refused": len(every) - len(judged),
        "gap_left_attached": _median(judged, "gap_left_attached"),
        "gap_left_file": _median(judged, "gap_left_file"),
        "file_worse_than_original": sum(arm["file_worse"] for arm in judged),
        "changed_for_nothing": sum(len(arm.get("changed", ())) for arm in judged),
    }


def _median(arms: list[dict[str, Any]], key: str) -> float:
    values = [arm[key] for arm in arms if key in arm]
    return float(np.median(values)) if values else np.nan


def _by_log(by_arm: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Figures of logs with torque, and of commands alone."""
    logs = sorted({arm["log"].partition(",")[0] for arm in by_arm.values()})
    return {log: summary([arm for arm in by_arm.values() if arm["log"].startswith(log)]) for log in logs}


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
