"""Forms in which controllers and simulators take a payload: one function each, `Body` and frame to text.

All refer to the flange frame of the arm's description, whose name they state. A controller expects loads in
its own flange frame, with the same origin and axes, so its form is only written if the frame is that one.
"""

from collections.abc import Callable, Iterable

import numpy as np

from exidyn.quoting import cpp_comment, hash_comment, krl_comment, one_line, xml_content

from ..arm.robot import FLANGE
from ..robot_files.urdf import FRANKA
from .body import Body

IN_FRAME = "in frame "
DECIMALS = 6
"""Decimals of SI values: micrograms, micrometers and 1 g m^2 / 1000 are below what any run determines."""


def number(value: float, decimals: int = DECIMALS) -> str:
    """A number without exponent, which no controller's language misreads; zero has no sign."""
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def numbers(values: Iterable[float], decimals: int = DECIMALS) -> str:
    """Numbers separated by commas."""
    return ", ".join(number(value, decimals) for value in values)


# https://www.universal-robots.com/manuals/EN/HTML/SW10_6/Content/prod-scriptmanual/G5/set_target_payload.htm
# m [kg]; cog [m] from the tool mount; inertia [kg m^2] as Ixx, Iyy, Izz, Ixy, Ixz, Iyz, with its origin in
# the center of gravity and axes along those of the tool flange. The same order as ur_msgs/SetPayload:
# https://docs.ros.org/en/jazzy/p/ur_msgs/srv/SetPayload.html


def universal_robots(body: Body, frame: str) -> str:
    """Call of set_target_payload: kg, m from the flange, kg m² about the center along the flange axes."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    return (
        f"set_target_payload({number(body.mass)}, [{numbers(body.center)}], "
        f"[{numbers((xx, yy, zz, xy, xz, yz))}])  {hash_comment(IN_FRAME + frame)}\n"
    )


# https://docs.ros.org/en/humble/p/franka_msgs/srv/SetLoad.html: the 3 x 3 inertia is in column-major order.
# https://raw.githubusercontent.com/frankarobotics/libfranka/main/include/franka/robot_state.h: F_x_Cload [m]
# is the center of mass in the flange frame, I_load [kg m^2] is with respect to the center of mass.


def franka(body: Body, frame: str) -> str:
    """Call of Robot::setLoad: kg, F_x_Cload in m, inertia in kg m² about the center, column-major."""
    inertia = body.inertia.flatten(order="F")
    return (
        f"robot.setLoad({number(body.mass)}, {{{numbers(body.center)}}}, {{{numbers(inertia)}}});  "
        f"{cpp_comment(IN_FRAME + frame)}\n"
    )


# https://www.easymanua.ls/kuka/iontec-kr-20-r3100/manual?p=40: M [kg]; center [mm]; the principal axes follow
# from the reference axes by A about Z, then B about the new Y, then C about the new X [degrees]; moments
# about the principal axes through the center of mass [kg m^2].
# https://infosys.beckhoff.com/content/1033/tf5120/13081587595.html: both relative to the flange; names M,
# X, Y, Z, A, B, C, JX, JY, JZ.

LOCKED = 1e-9
"""Cosine of B below which A and C turn about the same axis, so that only their sum is determined."""


def kuka(body: Body, frame: str) -> str:
    """LOAD_DATA: kg, mm and degrees from the flange, principal moments in kg m²; A, B, C about Z, Y', X''."""
    moments, axes = body.principal
    position = zip("XYZ", 1e3 * body.center, strict=True)
    angles = zip("ABC", angles_of(axes), strict=True)
    center = ",".join(f"{name} {number(value, 3)}" for name, value in (*position, *angles))
    inertia = ",".join(f"{name} {number(value)}" for name, value in zip("XYZ", moments, strict=True))
    return (
        f"LOAD_DATA[1]={{M {number(body.mass)},CM {{{center}}},J {{{inertia}}}}}\n"
        f"; JX, JY, JZ = {numbers(moments)} kgm^2; LOAD_DATA[n] is the load of tool n\n"
        f"{krl_comment(IN_FRAME + frame)}\n"
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


# http://docs.ros.org/en/noetic/api/abb_rapid_msgs/html/msg/LoadData.html and the RAPID reference
# (https://www.yumpu.com/en/document/view/5679047/basic-characteristics-rapid/183): mass [kg]; cog [mm], of a
# tool in the wrist coordinate system; aom, the principal axes at cog, as a quaternion q1 to q4 with the
# scalar first; ix, iy, iz [kg m^2] about these axes.


def abb(body: Body, frame: str) -> str:
    """loaddata: kg, mm, quaternion of the principal axes (scalar first), principal moments in kg m²."""
    moments, axes = body.principal
    return (
        f"PERS loaddata tool_load := [{number(body.mass)}, [{numbers(1e3 * body.center, 3)}], "
        f"[{numbers(quaternion(axes), 9)}], {numbers(moments)}];  ! {IN_FRAME}{one_line(frame)}\n"
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


# https://wiki.ros.org/urdf/XML/link: mass [kg]; inertia [kg m^2] about the center of mass, in axes that the
# origin gives; off-diagonal elements are minus the integral of x y.


def urdf(body: Body, frame: str) -> str:
    """Link to fix to the flange link: kg, m, kg m² about the center along the flange axes."""
    names = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    inertia = " ".join(f'i{"xyz"[i]}{"xyz"[j]}="{number(body.inertia[i, j], 9)}"' for i, j in names)
    center = " ".join(number(value) for value in body.center)
    return (
        f'{_xml_comment(frame)}<link name="payload">\n'
        "  <inertial>\n"
        f'    <origin xyz="{center}" rpy="0 0 0"/>\n'
        f'    <mass value="{number(body.mass)}"/>\n'
        f"    <inertia {inertia}/>\n"
        "  </inertial>\n"
        "</link>\n"
    )


# https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-inertial: pos [m] is the center of mass in
# the body's frame; fullinertia [kg m^2] is about it in the order xx, yy, zz, xy, xz, yz.


def mjcf(body: Body, frame: str) -> str:
    """Body to put into the flange body: kg, m, kg m² about the center along the flange axes."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    center = " ".join(number(value) for value in body.center)
    inertia = " ".join(number(value, 9) for value in (xx, yy, zz, xy, xz, yz))
    return (
        f'{_xml_comment(frame)}<body name="payload">\n'
        f'  <inertial pos="{center}" mass="{number(body.mass)}" fullinertia="{inertia}"/>\n'
        "</body>\n"
    )


def _xml_comment(frame: str) -> str:
    return f"<!-- {xml_content(IN_FRAME + one_line(frame)).replace('--', '- -')} -->\n"


FORMATS: dict[str, Callable[[Body, str], str]] = {
    "ur": universal_robots,
    "franka": franka,
    "kuka": kuka,
    "abb": abb,
    "urdf": urdf,
    "mjcf": mjcf,
}
"""Name -> function of body and frame; the first line of its docstring states what it writes."""
FRAMES = {"ur": ("tool0",), "kuka": ("tool0",), "abb": ("tool0",), "franka": FRANKA}
"""Controller -> names, or ends of names, of its own flange frame in descriptions."""


def is_own_flange(format: str, frame: str) -> bool:
    """Whether a form may refer to a frame: the controller's own flange, or `FLANGE`, a stated flange."""
    return format not in FRAMES or frame.lower().endswith(FRAMES[format]) or frame == FLANGE
