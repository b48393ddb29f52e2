"""A constant torque, or current."""

from ..findings.kind import Kind

KIND = Kind(
    sentence="{joint} has a constant offset of {Off}",
    drawn_against=("position", "velocity"),
    mistaken_for=("friction_asymmetry", "joint_spring"),
    settled_by="rests at poses reached from both sides (exidyn excite --kind poses)",
)
