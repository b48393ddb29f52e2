"""Drive gains of the UR10e from a body of known mass, and with them the mass of another body."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from common import show

from exidyn.identification.effects import EFFECTS, Prior
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload, Recording

from .data import DE_LUCA, LOADED, REPOSITORY, DataSet

KNOWN, UNKNOWN = "K", "U"
QUICK_RUNS = 2
REVERSAL = 0.02
"""Velocity over which load-dependent friction reverses [rad/s], about what Coulomb's is fitted to here."""


def payloads(data: DataSet, quick: bool) -> tuple[np.ndarray, dict[str, Any]]:
    """Tables of gains and masses.

    Returns:
        Drive gains from both bodies, shape (6,) [N m/A], and figures.
    """
    unloaded = [data.run(name) for name in data.train[: QUICK_RUNS if quick else None]]
    directions = [(LOADED[0], LOADED[1]), (LOADED[1], LOADED[0])]
    model = gears_model(data, unloaded)
    fits = [
        with_gears_load(
            data, model, [*unloaded, loaded(data, *known, KNOWN), loaded(data, other[0], None, UNKNOWN)]
        )
        for known, other in directions
    ]
    bodies = [loaded(data, *one, f"{KNOWN}{k}") for k, one in enumerate(LOADED)]
    both = with_gears_load(data, model, [*unloaded, *bodies])
    gain_table(fits, both)
    masses = [mass(fit) for fit in fits]
    errors = [100 * (value / other[1] - 1) for (value, _), (_, other) in zip(masses, directions, strict=True)]
    figures: dict[str, Any] = {
        "payload_error_percent": errors,
        "payload_std_percent": [
            100 * std / other[1] for (_, std), (_, other) in zip(masses, directions, strict=True)
        ],
        "drive_gain": both.estimate.gain,
        "drive_gain_std": both.estimate.gain_std,
        "drive_gain_by_direction": [fit.estimate.gain for fit in fits],
    }
    rows = [
        [f"exidyn, gains from {known[1]:g} kg", other[1], *found, error]
        for (known, other), found, error in zip(directions, masses, errors, strict=True)
    ]
    header = ["", "true [kg]", "found [kg]", "std [kg]", "error %"]
    show("ur10e: mass of the other body", header, rows)
    return both.estimate.gain, figures


def loaded(data: DataSet, name: str, kilograms: float | None, body: str) -> Recording:
    """A run with a body of which nothing is known, or its mass."""
    return data.run(name, KnownPayload(body, () if kilograms is None else (("M", kilograms),)))


def gears_model(data: DataSet, unloaded: Sequence[Recording]) -> Model:
    """Dry friction with presliding as the unloaded runs show it, and a part in proportion to the load."""
    model, dry = data.model(), EFFECTS["coulomb_friction"]
    effects = tuple(EFFECTS["hysteresis"]() if isinstance(e, dry) else e for e in model.effects)
    fit = identify(
        unloaded,
        model=replace(model, effects=effects),
        filtering=data.filtering,
        fitted_shapes=["hysteresis"],
        drop=False,
    )
    return fit.model + EFFECTS["load_dependent_friction"](reversal=REVERSAL)


def with_gears_load(data: DataSet, model: Model, runs: Sequence[Recording]) -> Fit:
    """Fit of gains and bodies with friction that grows with the torque that a gear transmits.

    A gear under load has more friction. A model without that lays the additional friction of the loaded runs
    on gains and masses. The load is first that of the drawn inertias, then that of the first fit.
    """
    first = identify(runs, model=model, filtering=data.filtering, drop=False)
    learnt = replace(first.model, stated=as_priors(first))
    return identify(runs, model=learnt, filtering=data.filtering, drop=False)


def as_priors(fit: Fit) -> dict[str, Prior]:
    """Standard parameters that give the fit's torque: base values in those kept, zero in the others."""
    priors = {name: Prior(0.0) for name in fit.model.names}
    for column, value in zip(fit.base.kept, fit.estimate.values, strict=True):
        priors[fit.model.names[column]] = Prior(float(value))
    return priors


def mass(fit: Fit) -> tuple[float, float]:
    """Mass of the unknown body and its standard deviation [kg], the gains' uncertainty included."""
    place = fit.names.index(f"M{UNKNOWN}")
    return float(fit.estimate.values[place]), float(fit.estimate.std[place])


def gain_table(fits: Sequence[Fit], both: Fit) -> None:
    """Drive gains from each body beside the published ones."""
    rows: list[list[Any]] = [["De Luca", *DE_LUCA], ["repository", *REPOSITORY]]
    labels = [*(f"from {kilograms:g} kg" for _, kilograms in LOADED), "from both"]
    for label, fit in zip(labels, (*fits, both), strict=True):
        rows += [[label, *fit.estimate.gain], ["  its std", *fit.estimate.gain_std]]
    header = ["drive gains [N m/A]", *(f"J{j + 1}" for j in range(6))]
    show("ur10e: drive gains from a body of which the mass is given", header, rows)
