"""Load-dependent friction: dry friction that grows with what the gear transmits."""

from ..findings.kind import Kind

KIND = Kind(
    sentence="{joint} has load-dependent friction: Coulomb friction grows by {mu} {effort} per {effort} "
    "that the gear transmits",
    drawn_against=("size of the load", "velocity"),
    mistaken_for=("torque_ripple", "nonlinear_viscous_friction", "drive_gain_saturation"),
    settled_by="a run with a body of known mass on the flange",
)
