"""Rotor inertia other than in the model."""

from ..findings.kind import Kind

KIND = Kind(
    sentence="{joint} has a rotor inertia {Ia:size} {Ia:larger|smaller} than in the model",
    drawn_against=("acceleration", "velocity"),
    reducible=True,
    mistaken_for=("joint_elasticity", "time_delay"),
)
