"""Nonlinear viscous friction: it grows with another power of speed than the first."""

from ..findings.kind import Kind

KIND = Kind(
    sentence="{joint} has nonlinear viscous friction: {Fn} at {one}[, growing with speed to the power "
    "{exponent:bare}]",
    drawn_against=("speed", "velocity"),
    shapes=tuple({"exponent": power} for power in (0.5, 0.8, 1.5, 2.0, 3.0)),
    mistaken_for=("stribeck_friction", "drive_gain_saturation", "viscous_friction"),
    settled_by="constant speeds up to the limit (exidyn excite --kind sweeps)",
)
