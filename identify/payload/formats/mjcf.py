"""MJCF of MuJoCo."""

from ..body import Body
from .numbers import number

# https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-inertial: pos [m] is the center of mass in
# the body's frame; fullinertia [kg m^2] is about it in the order xx, yy, zz, xy, xz, yz.


def mjcf(body: Body) -> str:
    """Body to put into the flange body: kg, m, kg m² about the center along the flange axes."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    center = " ".join(number(value) for value in body.center)
    inertia = " ".join(number(value, 9) for value in (xx, yy, zz, xy, xz, yz))
    return (
        '<body name="payload">\n'
        f'  <inertial pos="{center}" mass="{number(body.mass)}" fullinertia="{inertia}"/>\n'
        "</body>\n"
    )
