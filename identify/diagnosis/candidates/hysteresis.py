"""Hysteresis: friction that builds up over a displacement after each reversal."""

from ...effects import Shape
from ..findings.kind import Kind

KIND = Kind(
    sentence="{joint} has friction with hysteresis: {Fh} of it builds up[ over about {presliding:mrad}] "
    "after each reversal",
    drawn_against=("velocity", "position"),
    shapes=tuple({"presliding": way} for way in (1.5e-3, 4e-3, 1e-2, 2.5e-2)),
    bounds={"presliding": Shape("rad", 1e-3, 5e-2)},  # less is a nuisance
    mistaken_for=("stribeck_friction", "backlash", "joint_elasticity"),
    settled_by="constant low speeds (exidyn excite --kind sweeps)",
)
