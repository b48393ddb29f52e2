"""Coulomb friction other than in the model, or of a joint for which the model has none."""

from ..findings.kind import Kind

KIND = Kind(
    sentence="{joint} has a Coulomb friction {Fc:size} {Fc:higher|lower} than in the model",
    drawn_against=("velocity", "speed"),
    reducible=True,
    dry=True,
    mistaken_for=("stribeck_friction", "load_dependent_friction"),
)
