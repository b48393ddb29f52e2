"""RAPID of ABB."""

import numpy as np

from ..body import Body
from .numbers import number, numbers

# http://docs.ros.org/en/noetic/api/abb_rapid_msgs/html/msg/LoadData.html and the RAPID reference
# (https://www.yumpu.com/en/document/view/5679047/basic-characteristics-rapid/183): mass [kg]; cog [mm], of a
# tool in the wrist coordinate system; aom, the principal axes at cog, as a quaternion q1 to q4 with the
# scalar first; ix, iy, iz [kg m^2] about these axes.


def abb(body: Body) -> str:
    """loaddata: kg, mm, quaternion of the principal axes (scalar first), principal moments in kg m²."""
    moments, axes = body.principal
    return (
        f"PERS loaddata tool_load := [{number(body.mass)}, [{numbers(1e3 * body.center, 3)}], "
        f"[{numbers(quaternion(axes), 9)}], {numbers(moments)}];\n"
    )


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """Unit quaternion of a rotation matrix, scalar first and not negative, shape (4,).

    It is the eigenvector of the largest eigenvalue of a symmetric matrix (Bar-Itzhack 2000), which is
    accurate for any angle.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation
    matrix = np.array(
        [
            [xx + yy + zz, zy - yz, xz - zx, yx - xy],
            [zy - yz, xx - yy - zz, xy + yx, xz + zx],
            [xz - zx, xy + yx, yy - xx - zz, yz + zy],
            [yx - xy, xz + zx, yz + zy, zz - xx - yy],
        ]
    )
    vector = np.linalg.eigh(matrix)[1][:, -1]
    first = vector[np.flatnonzero(np.abs(vector) > 1e-12)[0]]
    return np.asarray(vector * np.sign(first))
