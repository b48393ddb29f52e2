"""Known masses on a real servo: how often the interval of one run contains what scales and a ruler say.

Eight bodies at two distances, some seconds a run, each run alone; the gain is the publishers', to 4 %. The
servo's friction grows with its load: with that in the model the intervals are those of the right physics.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from common import show

from exidyn.identification.effects import LoadDependentFriction
from exidyn.identification.effects.effect import Effect
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.robot_files.robot_file import read_model

from .data import FOLDER

GAIN, TOLERANCE = 0.53, 0.04
"""Of the eight bodies together [N m/V], and the scatter between them."""
NO_TORQUE = "lift_and_drop"
"""Runs in which the servo is off for the most part."""
MODELS: dict[str, tuple[Effect, ...]] = {"as usual": (), "with load friction": (LoadDependentFriction(),)}


def deviations(more: tuple[Effect, ...]) -> Iterator[float]:
    """First moments of all runs, identified minus known, in standard deviations."""
    folder = FOLDER / "kscale_sts3215"
    for path in sorted(folder.glob("m*.csv.gz")):
        if NO_TORQUE in path.name:
            continue
        model = read_model(folder / f"robot_{'_'.join(path.name.split('_')[:2])}.toml")
        robot = replace(model.robot, drive_gain=np.array([GAIN]), drive_gain_tolerance=np.array([TOLERANCE]))
        model = replace(model, robot=robot, effects=(*model.effects, *more))
        fit = identify([import_source(path, model)[0]])
        known = fit.base.regrouping @ fit.model.nominal_values
        place = next(k for k, name in enumerate(fit.names) if name.startswith("MZ"))
        yield float((fit.estimate.values[place] - known[place]) / fit.estimate.std[place])


def servo_masses() -> dict[str, Any]:
    """A table, and how many of the intervals contain the known value."""
    figures: dict[str, Any] = {}
    for name, more in MODELS.items():
        away = np.array(list(deviations(more)))
        figures[name] = {"within_95": 100 * float(np.mean(np.abs(away) < 1.96)), "of": len(away)}
    rows = [[name, one["within_95"], one["of"]] for name, one in figures.items()]
    show("kscale_sts3215: known mass within its 95 % interval", ["model", "%", "of runs"], rows)
    return figures
