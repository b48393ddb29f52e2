"""KRL of KUKA."""

import numpy as np

from ..body import Body
from .numbers import number, numbers

# https://www.easymanua.ls/kuka/iontec-kr-20-r3100/manual?p=40: M [kg]; center [mm]; the principal axes follow
# from the reference axes by A about Z, then B about the new Y, then C about the new X [degrees]; moments
# about the principal axes through the center of mass [kg m^2].
# https://infosys.beckhoff.com/content/1033/tf5120/13081587595.html: both relative to the flange; names M,
# X, Y, Z, A, B, C, JX, JY, JZ.

LOCKED = 1e-9
"""Cosine of B below which A and C turn about the same axis, so that only their sum is determined."""


def kuka(body: Body) -> str:
    """LOAD_DATA: kg, mm and degrees from the flange, principal moments in kg m²; A, B, C about Z, Y', X''."""
    moments, axes = body.principal
    position = zip("XYZ", 1e3 * body.center, strict=True)
    angles = zip("ABC", angles_of(axes), strict=True)
    center = ",".join(f"{name} {number(value, 3)}" for name, value in (*position, *angles))
    inertia = ",".join(f"{name} {number(value)}" for name, value in zip("XYZ", moments, strict=True))
    return (
        f"LOAD_DATA[1]={{M {number(body.mass)},CM {{{center}}},J {{{inertia}}}}}\n"
        f"; JX, JY, JZ = {numbers(moments)} kgm^2; LOAD_DATA[n] is the load of tool n\n"
    )


def angles_of(rotation: np.ndarray) -> tuple[float, float, float]:
    """A, B, C [degrees] with rotation = Rz(A) Ry(B) Rx(C)."""
    cosine = float(np.hypot(rotation[0, 0], rotation[1, 0]))
    b = np.arctan2(-rotation[2, 0], cosine)
    if cosine < LOCKED:
        a, c = np.arctan2(-rotation[0, 1], rotation[1, 1]), 0.0
    else:
        a = np.arctan2(rotation[1, 0], rotation[0, 0])
        c = np.arctan2(rotation[2, 1], rotation[2, 2])
    a, b, c = np.degrees([a, b, c])
    return float(a), float(b), float(c)
