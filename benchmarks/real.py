"""Real arms: gains and an unknown mass of a UR10e, held-out residuals of three arms, and intervals of five.

The model is the README's (rigid body, rotors, viscous and dry friction, offset). How dry friction reverses,
from which speed on a joint counts as sliding, and the tolerance of the drawn inertias is chosen by
predicting each training run from the others. Held-out runs do not enter that choice, but whoever drew up
what there is to choose from had seen them, so margins of a per cent mean little.

Residuals are compared in the README's own manner: everything through one zero-phase Butterworth over the
whole file, samples above its threshold of speed, norm of the residual over norm of the torque. One of the
loaded runs repeats the motion of a held-out run; it gives that run's prediction its drive gains, no more.
"""

import contextlib
import io
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import combinations
from multiprocessing import get_context
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one thread a process, and two processes

import numpy as np
from common import options, save, show
from parts.adequacy.recordings import CORRECT
from parts.real.choice import LAWS, Compared, choose, in_words
from parts.real.data import FOLDER, KR300, PANDA, UR10E, DataSet
from parts.real.payload import payloads

from exidyn.identification.fit.estimators import weighted
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model
from exidyn.identification.text_table import NORMAL_95

TOLERANCES = (None, 3.0, 1.0, 0.3, 0.1)
"""Relative standard deviations of the drawn inertias as prior; None for no prior."""
QUICK_TOLERANCES = (None, 1.0, 0.1)
SEVERAL = ("airbot_play", "baxter_left", "dvrk_psm", "kuka_lwr4", UR10E.key)
"""Arms with several recordings of other motions."""


def pooled(relative: np.ndarray) -> np.ndarray:
    """Root mean square over files, (files, n) -> (n,)."""
    return np.sqrt(np.mean(relative**2, axis=0))


def residuals(data: DataSet, model: Model, quick: bool) -> dict[str, Any]:
    """Held-out relative residuals beside the README's."""
    runs = [data.run(name) for name in data.train]
    tolerances = (QUICK_TOLERANCES if quick else TOLERANCES) if data.weighed else (None,)
    recipe, candidates = choose(data, model, runs, tolerances)
    held_out = [data.run(name) for name in data.held_out]
    found = {}
    for laws in dict.fromkeys([recipe.laws, *((law,) * model.robot.dof for law in LAWS)]):
        fit = candidates.final(recipe._replace(laws=laws))
        figures = [Compared.of(fit, run, data).relative(fit.estimate.values) for run in held_out]
        found[in_words(laws)] = np.array(figures)
    over = {law: pooled(relative) / pooled(data.yardstick) for law, relative in found.items()}
    ours = found[in_words(recipe.laws)]
    residual_table(data, ours, over)
    return {
        "residual_over_yardstick": over[in_words(recipe.laws)],
        "residual_over_yardstick_by_file": dict(zip(data.held_out, ours / data.yardstick, strict=True)),
        "residual_over_yardstick_by_law": over,
        "relative_residual_by_file": dict(zip(data.held_out, ours, strict=True)),
        "choice": recipe._asdict(),
    }


def residual_table(data: DataSet, ours: np.ndarray, over: dict[str, np.ndarray]) -> None:
    """Ours (files, n) beside the yardstick, file by file; all files by law, the chosen one first."""
    rows: list[list[Any]] = []
    for name, mine, theirs in zip(data.held_out, ours, data.yardstick, strict=True):
        rows += [[name, "yardstick", *theirs], ["", "exidyn", *mine], ["", "ratio", *(mine / theirs)]]
    for place, (law, ratio) in enumerate(over.items()):
        rows.append(["  the same with" if place else "all, rms", law if place else "ratio", *ratio])
    joints = [f"J{j + 1}" for j in range(ours.shape[1])]
    show(f"{data.key}: relative residual on held-out runs", ["run", "", *joints], rounded(rows))


def rounded(rows: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """Numbers with four decimals."""
    return [[value if isinstance(value, str) else round(float(value), 4) for value in row] for row in rows]


def study(data: DataSet, quick: bool) -> tuple[str, dict[str, Any]]:
    """Tables, as text, and figures of one arm."""
    model, figures, text = data.model(), {}, io.StringIO()
    with contextlib.redirect_stdout(text):
        if data.key == UR10E.key:
            gains, figures = payloads(data, quick)
            model = replace(model, robot=replace(model.robot, drive_gain=gains))
        figures |= residuals(data, model, quick)
    return text.getvalue(), figures


def intervals() -> dict[str, float]:
    """Share of base parameters in which two recordings of an arm differ beyond their 95 % intervals."""
    fits, shares = {name: _fitted(name) for name in CORRECT if name.split()[0] in SEVERAL}, {}
    for (name, fit), (other, again) in combinations(fits.items(), 2):
        arm = name.split()[0]
        if arm == other.split()[0] and fit.base.names == again.base.names:
            (one, two), std = (
                (fit.estimate.values, again.estimate.values),
                (fit.estimate.std, again.estimate.std),
            )
            shares.setdefault(arm, []).append(np.mean(np.abs(one - two) > NORMAL_95 * np.hypot(*std)))
    rows = [[arm, len(each), float(np.mean(each))] for arm, each in shares.items()]
    show("Parameters that differ beyond 95 % intervals; 0.05 is right", ["arm", "pairs", "share"], rows)
    return {arm: share for arm, _, share in rows}


def _fitted(name: str) -> Fit:
    return identify([CORRECT[name]().run], estimator=weighted, drop=False)


def main() -> None:
    chosen = options(__doc__.splitlines()[0])
    if not (FOLDER / UR10E.urdf).exists():
        print(f"no recordings in {FOLDER}; set EXIDYN_DATA to their folder")
        return
    sets, results = (UR10E, KR300, PANDA), {}
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        for data, (text, figures) in zip(sets, pool.map(study, sets, [chosen.quick] * 3), strict=True):
            print(text, end="", flush=True)
            results[data.key] = figures
    results["differ_beyond_intervals"] = intervals()
    save(chosen.json, results)


if __name__ == "__main__":
    main()
