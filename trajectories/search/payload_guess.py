"""What to expect of a payload of which not all is told, so that a pair of runs can be planned with it."""

from dataclasses import replace

from exidyn.identify.effects import Belief, Payload, known_parameters
from exidyn.identify.model import Model

DENSITY = 4000.0
"""Of a body on a flange [kg/m^3]: half of steel, since test weights are plates with gaps between them."""


def with_payload(model: Model, known: tuple[tuple[str, float], ...], name: str = "L") -> Model:
    """The model with a body on the flange; what is not told of it is guessed, without weight.

    The guess is a cube of `DENSITY` that stands on the flange's z axis, or about the centre of mass if that
    is told. It says how much torque to expect, and never enters a fit.
    """
    told = dict(known)
    mass = told["M"]
    side = (mass / DENSITY) ** (1 / 3)
    inertia = mass * side**2 / 6
    if "MX" in told:
        centre = tuple(told[key] / mass for key in ("MX", "MY", "MZ"))
    else:
        centre = (0.0, 0.0, 0.5 * side)
    guess = dict(known_parameters(mass, centre, (inertia, 0.0, 0.0, inertia, 0.0, inertia)))
    stated = {f"{key}{name}": Belief(value) for key, value in guess.items() if key not in told}
    return replace(model + Payload(name, known), stated={**model.stated, **stated})
