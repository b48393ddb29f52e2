"""Viscous friction other than in the model."""

from ..findings.kind import Kind

KIND = Kind(
    sentence="{joint} has a viscous friction {Fv:size} {Fv:higher|lower} than in the model",
    drawn_against=("velocity", "speed"),
    reducible=True,
    mistaken_for=("nonlinear_viscous_friction", "temperature_dependent_friction"),
)
