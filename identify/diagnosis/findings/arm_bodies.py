"""Bodies of an arm that are heavier or lighter than in its model."""

import numpy as np

from ...arm.rigid_regressor import INERTIAL
from .arm import Arm
from .finding import Finding


def heavier(arm: Arm, link: int, body: np.ndarray) -> Arm | None:
    """The arm whose link has a further body, given by its pseudo-inertia (4, 4) in the link's frame."""
    more = {f"{name}{link + 1}": value for name, value in inertial_values(body).items()}
    return arm.with_values(more) if set(more) <= set(arm.model.names) else None


def found_body(finding: Finding, ending: str = "") -> np.ndarray:
    """Pseudo-inertia (4, 4) of a finding's parameters whose names end so."""
    names = [name for name in INERTIAL if f"{name}{ending}" in finding.parameters]
    return pseudo_inertia({name: finding.parameters[f"{name}{ending}"].value for name in names})


def pseudo_inertia(values: dict[str, float]) -> np.ndarray:
    """Integral of density times (x, y, z, 1) times its transpose, shape (4, 4); what is not given is zero.

    Unlike an inertia about the centre of mass it is linear, and moves from frame to frame for any numbers.
    """
    xx, xy, xz, yy, yz, zz = (values.get(name, 0.0) for name in ("XX", "XY", "XZ", "YY", "YZ", "ZZ"))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    out = np.zeros((4, 4))
    out[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    out[:3, 3] = out[3, :3] = [values.get(name, 0.0) for name in ("MX", "MY", "MZ")]
    out[3, 3] = values.get("M", 0.0)
    return out


def inertial_values(pseudo: np.ndarray) -> dict[str, float]:
    """The ten parameters of a body out of its pseudo-inertia (4, 4)."""
    inertia = np.trace(pseudo[:3, :3]) * np.eye(3) - pseudo[:3, :3]
    found = {f"{'XYZ'[i]}{'XYZ'[j]}": inertia[i, j] for i in range(3) for j in range(i, 3)}
    found |= {f"M{axis}": pseudo[place, 3] for place, axis in enumerate("XYZ")}
    return {name: float(({"M": pseudo[3, 3]} | found)[name]) for name in INERTIAL}
