"""Edit test of the UR10e: a body is put on, and taken off, and the fit predicts that run as it is."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from exidyn.identification.arm.rigid_regressor import INERTIAL
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload, Recording

from ..edit_test import edit_test_table
from .data import LOADED, DataSet

BODY = "K"
WITH, WITHOUT = "id_ur-20_01_31-load", "id_ur-20_01_31-unload"
"""The same motion with the body of the first of `LOADED`, and without."""


def edits(data: DataSet, quick: bool) -> dict[str, Any]:
    """Residuals of both directions, with published gains and with those that the body's mass gives.

    The body is known to its mass; its other numbers are those of a fit of another run that carries it.
    """
    unloaded = [data.run(name) for name in data.train[: 2 if quick else None]]
    name, kilograms = LOADED[0]
    weighed = data.run(name, KnownPayload(BODY, (("M", kilograms),)))
    body = identify([*unloaded, weighed], model=data.model(), filtering=data.filtering, drop=False)
    calibrated = replace(data.model().robot, drive_gain=body.estimate.gain)
    numbers, fits = _numbers(body, kilograms), {}
    for label, robot in (("published gains", data.model().robot), ("calibrated gains", calibrated)):
        arm = _Arm(data, replace(data.model(), robot=robot), KnownPayload(BODY, numbers))
        held_out = [data.run(data.held_out[0]), data.run(WITHOUT), arm.carrying(WITH)]
        fits[f"put on, {label}"] = arm.fit(unloaded, held_out)
        fits[f"taken off, {label}"] = arm.fit([arm.carrying(name)], [arm.carrying(WITH), data.run(WITHOUT)])
    return edit_test_table("ur10e: edit test, nothing fitted again", fits)


class _Arm(NamedTuple):
    """The arm with drive gains, and the body that is put on and taken off."""

    data: DataSet
    model: Model
    body: KnownPayload

    def carrying(self, run: str) -> Recording:
        """A run with the body."""
        return self.data.run(run, self.body)

    def fit(self, used: Sequence[Recording], held_out: Sequence[Recording]) -> Fit:
        """A fit of some runs, which predicts others."""
        return identify(used, held_out, model=self.model, filtering=self.data.filtering, as_recorded=True)


def _numbers(fit: Fit, kilograms: float) -> tuple[tuple[str, float], ...]:
    """The ten numbers of the body: its weight, and what a fit found of the others."""
    found = dict(zip(fit.names, map(float, fit.estimate.values), strict=True))
    return tuple((part, kilograms if part == "M" else found[f"{part}{BODY}"]) for part in INERTIAL)
