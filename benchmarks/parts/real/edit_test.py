"""Edit test of the UR10e: a body is put on, and taken off, and the fit predicts that run as it is."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from exidyn.identify.arm.rigid_regressor import INERTIAL
from exidyn.identify.fit.fit import Fit
from exidyn.identify.fit.identification import identify
from exidyn.identify.recordings.recording import KnownPayload, Recording

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
    fits = {}
    for label, robot in (("published gains", data.model().robot), ("calibrated gains", calibrated)):
        model = replace(data.model(), robot=robot)

        def carrying(run: str, known: bool) -> Recording:
            return data.run(run, KnownPayload(BODY, _numbers(body, kilograms)) if known else None)

        def fitted(used: Sequence[Recording], *held_out: Recording) -> Fit:
            return identify(used, held_out, model=model, filtering=data.filtering, as_recorded=True)

        held_out = [data.run(run) for run in data.held_out[:1]]
        fits[f"put on, {label}"] = fitted(unloaded, *held_out, carrying(WITHOUT, False), carrying(WITH, True))
        fits[f"taken off, {label}"] = fitted([carrying(name, True)], carrying(WITH, True), carrying(WITHOUT, False))
    return edit_test_table("ur10e: edit test, nothing fitted again", fits)


def _numbers(fit: Fit, kilograms: float) -> tuple[tuple[str, float], ...]:
    """The ten numbers of the body: its weight, and what a fit found of the others."""
    found = dict(zip(fit.names, map(float, fit.estimate.values), strict=True))
    return tuple((part, kilograms if part == "M" else found[f"{part}{BODY}"]) for part in INERTIAL)
