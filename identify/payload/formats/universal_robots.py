"""URScript of Universal Robots."""

from ..body import Body
from .numbers import number, numbers

# https://www.universal-robots.com/manuals/EN/HTML/SW10_6/Content/prod-scriptmanual/G5/set_target_payload.htm
# m [kg]; cog [m] from the tool mount; inertia [kg m^2] as Ixx, Iyy, Izz, Ixy, Ixz, Iyz, with its origin in
# the center of gravity and axes along those of the tool flange. The same order as ur_msgs/SetPayload:
# https://docs.ros.org/en/jazzy/p/ur_msgs/srv/SetPayload.html


def universal_robots(body: Body) -> str:
    """Call of set_target_payload: kg, m from the flange, kg m² about the center along the flange axes."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    return (
        f"set_target_payload({number(body.mass)}, [{numbers(body.center)}], "
        f"[{numbers((xx, yy, zz, xy, xz, yz))}])\n"
    )
