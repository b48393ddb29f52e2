"""Where the centre of mass of each payload is, from what was known and what was found of it."""

import numpy as np

from ..effects import Payload
from ..text_table import digits
from .fit import Fit


def payload_centres(fit: Fit) -> list[str]:
    """A sentence for each body whose mass is known or identified.

    None where first moments are per unit of drive gain: a mass in kilograms does not divide those.
    """
    if fit.unscaled:
        return []
    bodies = [effect for effect in fit.model.effects if isinstance(effect, Payload)]
    return [words for body in bodies if (words := _centre(fit, body))]


def _centre(fit: Fit, body: Payload) -> str:
    mass = _value(fit, body, "M")
    if mass is None or not mass > 0.0:
        return ""
    axes = [f"{axis.lower()} {_coordinate(fit, body, axis, mass)}" for axis in "XYZ"]
    return f"payload {body.name}: centre of mass in the flange's frame [m]: {', '.join(axes)}"


def _coordinate(fit: Fit, body: Payload, axis: str, mass: float) -> str:
    """First moment over mass, with its standard deviation where either was estimated."""
    moment = _value(fit, body, f"M{axis}")
    if moment is None:
        return "open"
    if f"M{axis}{body.name}" in fit.dropped:
        return "0 (dropped)"
    slope = np.zeros(len(fit.names))
    for name, derivative in ((f"M{axis}", 1.0 / mass), ("M", -moment / mass**2)):
        if f"{name}{body.name}" in fit.names:
            slope[fit.names.index(f"{name}{body.name}")] = derivative
    count = len(slope)
    std = float(np.sqrt(slope @ fit.estimate.covariance[:count, :count] @ slope))
    return digits(moment / mass) + (f" \N{PLUS-MINUS SIGN} {digits(std)}" if std else " (known)")


def _value(fit: Fit, body: Payload, name: str) -> float | None:
    """A parameter of the body: as known, as identified alone, zero if dropped; None if only in a sum."""
    if name in dict(body.known):
        return dict(body.known)[name]
    own = f"{name}{body.name}"
    if own in fit.names:
        return float(fit.estimate.values[fit.names.index(own)])
    return 0.0 if own in fit.dropped else None
