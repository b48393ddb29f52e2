"""Torque that is left of held-out runs when a feedforward is subtracted, joint by joint.

The fit is the library's own, from the training runs. Torques have passed the decimation filter of the fit,
and samples in which a joint stands do not count: what holds it is not known.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from common import show

from exidyn.identification.arm.motion import Motion
from exidyn.identification.feedforward.feedforward import Feedforward, make_feedforward
from exidyn.identification.fit.fit import Fit
from exidyn.identification.preparation.prepare import Prepared, prepare
from exidyn.identification.recordings.recording import Recording

WHAT = ("gravity", "gravity and friction", "compensation", "inverse dynamics")
"""What is subtracted: holding torque; friction in full; friction as it is compensated, to 70 %; all."""


def left(name: str, fit: Fit, runs: Sequence[Recording]) -> dict[str, Any]:
    """A table: root mean square torque of all runs, and the share of it that is left [%]."""
    feedforward = make_feedforward(fit)
    squares = np.array([_squares(feedforward, prepare(run, fit.filtering)) for run in runs]).sum(axis=0)
    counts, measured, *rest = squares
    rms = np.sqrt(measured / np.maximum(counts, 1.0))
    shares = {what: 100.0 * np.sqrt(part / measured) for what, part in zip(WHAT, rest, strict=True)}
    joints = [f"J{j + 1}" for j in range(len(rms))]
    rows = [["torque [N m]", *rms], *([f"after {what} [%]", *values] for what, values in shares.items())]
    show(f"{name}: torque of held-out runs, and what is left of it", ["", *joints], rows)
    return {"torque_rms": rms, "left_percent": shares}


def _squares(feedforward: Feedforward, run: Prepared) -> np.ndarray:
    """Number of samples, and sums of squares of the measured torque and of each remainder, (6, n)."""
    gain = 1.0 if feedforward.gain is None else feedforward.gain
    measured = run.decimation.apply((gain * run.current) @ feedforward.robot.coupling)
    parts = [run.decimation.apply(part) for part in _predicted(feedforward, run.motion)]
    remainders = [measured, *(measured - part for part in parts)]
    return np.array([run.weight.sum(axis=0), *(np.sum(run.weight * r**2, axis=0) for r in remainders)])


def _predicted(feedforward: Feedforward, motion: Motion) -> list[np.ndarray]:
    """Torques in the order of `WHAT`, each (t, n)."""
    q, dq, warm = motion.position, motion.velocity, motion.temperature
    gravity = feedforward.gravity(q, warm)
    return [
        gravity,
        gravity + feedforward.friction(q, dq, warm),
        feedforward.compensation(q, dq, warm),
        feedforward.torque(q, dq, motion.acceleration, warm),
    ]
