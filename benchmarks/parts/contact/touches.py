"""Simulated touches: which forces are found at one false alarm an hour, and after which time."""

from typing import Any

import numpy as np
from common import show

from exidyn.identification.contact.alarms import Alarms
from exidyn.identification.contact.contact import observed
from exidyn.identification.contact.threshold import Threshold
from exidyn.identification.fit.identification import identify

from . import touched_arm

FORCES = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
"""Sizes of the touches [N]."""
EVERY, LASTS, FIRST = 3.0, 1.0, 2.0
"""Time between touches, their duration and the first one [s]."""


def touches(quick: bool) -> dict[str, Any]:
    """A table by force: found, median delay, error of the force."""
    fit = identify([touched_arm.run("train", 1)])
    free = [observed(fit, touched_arm.run(f"free {k}", 10 + k, 60.0)) for k in range(1 if quick else 4)]
    threshold = Threshold.of(free, fit.standstill)
    rows, figures = [], dict[str, Any]()
    for place, size in enumerate(FORCES):
        found, delays, errors, others, count = _touched(fit, threshold, size, 100 + place, 5 if quick else 20)
        rows.append([size, 100.0 * found / count, _median(delays), _median(errors), others])
        figures[f"{size:g} N"] = {"found_percent": 100.0 * found / count, "delay_ms": _median(delays)}
    header = ["force [N]", "found [%]", "delay [ms]", "error of force [N]", "other alarms"]
    show("touched arm in MuJoCo: touches of a second in random directions", header, rows)
    found_all = [size for size, row in zip(FORCES, rows, strict=True) if row[1] >= 95.0]
    return figures | {"least_force_found": min(found_all, default=None)}


def _touched(
    fit: Any, threshold: Threshold, size: float, seed: int, count: int
) -> tuple[int, list[float], list[float], int, int]:
    """Touches found, delays [ms], errors of the force [N], alarms at other times, and touches made."""
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    forces = size * directions / np.linalg.norm(directions, axis=1)[:, None]
    touched = [
        touched_arm.Touch(tuple(force), FIRST + EVERY * k, FIRST + EVERY * k + LASTS)
        for k, force in enumerate(forces)
    ]
    run = touched_arm.run("touched", seed, FIRST + EVERY * count, touched)
    alarms = Alarms(threshold)
    alarms.add(observed(fit, run))
    delays, errors, matched = [], [], 0
    for touch in touched:
        inside = [alarm for alarm in alarms.all if touch.start <= alarm.start < touch.end]
        if inside:
            matched += len(inside)
            delays.append(1e3 * (inside[0].start - touch.start))
            wrench = inside[0].wrench(fit.model.robot)[:3]
            errors.append(float(np.linalg.norm(wrench - touch.force)))
    return len(delays), delays, errors, len(alarms.all) - matched, count


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else np.nan
