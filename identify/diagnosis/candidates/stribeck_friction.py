"""Stribeck friction: dry friction that rises towards standstill."""

from ..findings.kind import Kind

KIND = Kind(
    sentence="{joint} has Stribeck friction: friction rises by {Fs} towards standstill[, most of which is "
    "gone at {fade}]",
    drawn_against=("speed", "velocity"),
    shapes=tuple({"fade": speed} for speed in (0.02, 0.05, 0.12, 0.3)),
    dry=True,
    mistaken_for=("hysteresis", "nonlinear_viscous_friction", "backlash"),
    settled_by="constant low speeds (exidyn excite --kind sweeps)",
)
