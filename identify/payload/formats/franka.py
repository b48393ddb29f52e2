"""libfranka of Franka Robotics."""

from ..body import Body
from .numbers import number, numbers

# https://docs.ros.org/en/humble/p/franka_msgs/srv/SetLoad.html: the 3 x 3 inertia is in column-major order.
# https://raw.githubusercontent.com/frankarobotics/libfranka/main/include/franka/robot_state.h: F_x_Cload [m]
# is the center of mass in the flange frame, I_load [kg m^2] is with respect to the center of mass.


def franka(body: Body) -> str:
    """Call of Robot::setLoad: kg, F_x_Cload in m, inertia in kg m² about the center, column-major."""
    inertia = body.inertia.flatten(order="F")
    return f"robot.setLoad({number(body.mass)}, {{{numbers(body.center)}}}, {{{numbers(inertia)}}});\n"
