"""Where the centre of mass of each payload is, from what was known and what was found of it."""

import numpy as np

from ..effects import Effect
from ..text_table import digits
from .fit import Fit


def payload_centres(fit: Fit) -> list[str]:
    """A sentence for each body whose mass is known or identified.

    None where first moments are per unit of drive gain: a mass in kilograms does not divide those.
    """
    if fit.unscaled:
        return []
    return [words for body in fit.model.payloads.values() if (words := _centre(fit, body))]


def _centre(fit: Fit, body: Effect) -> str:
    mass = _value(fit, body, "M")
    if mass is None or not mass > 0.0:
        return ""
    axes = [f"{axis.lower()} {_coordinate(fit, body, axis, mass)}" for axis in "XYZ"]
    return f"payload {body.payload}: centre of mass in the flange's frame [m]: {', '.join(axes)}"


def _coordinate(fit: Fit, body: Effect, axis: str, mass: float) -> str:
    """First moment over mass, with its standard deviation where either was estimated."""
    moment = _value(fit, body, f"M{axis}")
    if moment is None:
        return "open"
    if f"M{axis}{body.payload}" in fit.dropped:
        return "0 (dropped)"
    slope = np.zeros(len(fit.names))
    for name, derivative in ((f"M{axis}", 1.0 / mass), ("M", -moment / mass**2)):
        if f"{name}{body.payload}" in fit.names:
            slope[fit.names.index(f"{name}{body.payload}")] = derivative
    count = len(slope)
    std = float(np.sqrt(slope @ fit.estimate.covariance[:count, :count] @ slope))
    return digits(moment / mass) + (f" \N{PLUS-MINUS SIGN} {digits(std)}" if std else " (known)")


def _value(fit: Fit, body: Effect, name: str) -> float | None:
    """A parameter of the body: as known, as identified alone, zero if dropped; None if only in a sum."""
    if name in dict(body.known):
        return dict(body.known)[name]
    own = f"{name}{body.payload}"
    if own in fit.names:
        return float(fit.estimate.values[fit.names.index(own)])
    return 0.0 if own in fit.dropped else None
