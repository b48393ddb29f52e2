"""URDF of ROS."""

from ..body import Body
from .numbers import number

# https://wiki.ros.org/urdf/XML/link: mass [kg]; inertia [kg m^2] about the center of mass, in axes that the
# origin gives; off-diagonal elements are minus the integral of x y.


def urdf(body: Body) -> str:
    """Link to fix to the flange link: kg, m, kg m² about the center along the flange axes."""
    names = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    inertia = " ".join(f'i{"xyz"[i]}{"xyz"[j]}="{number(body.inertia[i, j], 9)}"' for i, j in names)
    center = " ".join(number(value) for value in body.center)
    return (
        '<link name="payload">\n'
        "  <inertial>\n"
        f'    <origin xyz="{center}" rpy="0 0 0"/>\n'
        f'    <mass value="{number(body.mass)}"/>\n'
        f"    <inertia {inertia}/>\n"
        "  </inertial>\n"
        "</link>\n"
    )
