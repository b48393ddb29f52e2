"""What a feedforward leaves of the torque of held-out public recordings, and what a call of it costs.

Arms: a UR10e and a KUKA KR300 (`EXIDYN_DATA` names their folder; without it only the times of the built-in
KR270 are measured).
"""

import os
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one thread

import numpy as np
from common import options, save
from parts.compensate import left, times
from parts.real.data import FOLDER, KR300, UR10E, DataSet

from exidyn.identification.dynamics.dynamics import Dynamics
from exidyn.identification.feedforward.feedforward import SHARE, Feedforward, make_feedforward
from exidyn.identification.fit.identification import identify
from exidyn.identification.robot_files.robot_file import read_model

CALLS, QUICK_CALLS = 200_000, 40_000


def of_arm(data: DataSet, quick: bool) -> tuple[dict[str, Any], Feedforward]:
    """Figures of an arm's held-out runs, and its feedforward."""
    train, held_out = (data.train[:2], data.held_out[:1]) if quick else (data.train, data.held_out)
    fit = identify([data.run(name) for name in train], filtering=data.filtering)
    return left(data.key, fit, [data.run(name) for name in held_out]), make_feedforward(fit)


def built_in() -> Feedforward:
    """The built-in KR270, with its spring balancer, at its nominal values."""
    model = read_model("kr270")
    n = model.robot.dof
    dynamics, gain = Dynamics.of(model, model.nominal_values), model.robot.drive_gain
    return Feedforward(dynamics, "N m", gain, None, np.full(n, 0.01), SHARE, (), ("nominal",))


def main() -> None:
    """All tables."""
    given = options(__doc__)
    calls = QUICK_CALLS if given.quick else CALLS
    figures: dict[str, Any] = {"times": {"kr270": times("kr270", built_in(), calls)}}
    if FOLDER.exists():
        figures["left"] = {}
        for data in (UR10E,) if given.quick else (UR10E, KR300):
            figures["left"][data.key], feedforward = of_arm(data, given.quick)
            figures["times"][data.key] = times(data.key, feedforward, calls)
    else:
        print(f"\nno public recordings in {FOLDER}: EXIDYN_DATA names their folder")
    save(given.json, figures)


if __name__ == "__main__":
    main()
