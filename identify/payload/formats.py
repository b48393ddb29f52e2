"""Forms in which controllers and simulators take a payload: one table, from a body and a frame to text.

All refer to the flange frame of the arm's description, whose name they state. A controller expects loads in
its own flange frame, with the same origin and axes, so its form is only written if the frame is that one.
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.quoting import cpp_comment, hash_comment, krl_comment, one_line, xml_content

from ..arm.robot import FLANGE
from ..robot_files.urdf import FRANKA
from .body import Body

DECIMALS = 6
"""Decimals of SI values: micrograms, micrometers and 1 g m^2 / 1000 are below what any run determines."""


class Form(NamedTuple):
    """How a controller or simulator takes a payload."""

    title: str  # what it is, with units
    text: str  # template with the names of `fields`, and `note`, which states the frame
    note: Callable[[str], str]  # function that makes a comment of a text
    frames: tuple[str, ...] = ()  # names, or ends of names, of the controller's own flange; none: any frame

    def __call__(self, body: Body, frame: str) -> str:
        """Text of a payload in a frame."""
        return self.text.format(note=self.note(f"in frame {frame}"), **fields(body))


def number(value: float, decimals: int = DECIMALS) -> str:
    """A number without exponent, which no controller's language misreads; zero has no sign."""
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def numbers(values: Iterable[float], decimals: int = DECIMALS, between: str = ", ") -> str:
    """Numbers separated by commas, or by another text."""
    return between.join(number(value, decimals) for value in values)


def fields(body: Body) -> dict[str, str]:
    """Numbers of a body in text, by their names in the templates."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    moments, axes = body.principal
    coordinates = zip("XYZABC", (*(1e3 * body.center), *angles_of(axes)), strict=True)
    elements = {"ixx": xx, "ixy": xy, "ixz": xz, "iyy": yy, "iyz": yz, "izz": zz}
    return {
        "mass": number(body.mass),
        "center": numbers(body.center),
        "center_words": numbers(body.center, between=" "),
        "center_mm": numbers(1e3 * body.center, 3),
        "center_and_angles": ",".join(f"{name} {number(value, 3)}" for name, value in coordinates),
        "inertia": numbers((xx, yy, zz, xy, xz, yz)),
        "inertia_words": numbers((xx, yy, zz, xy, xz, yz), 9, " "),
        "inertia_columns": numbers(body.inertia.flatten(order="F")),
        "inertia_attributes": " ".join(f'{name}="{number(value, 9)}"' for name, value in elements.items()),
        "moments": numbers(moments),
        "named_moments": ",".join(f"{a} {number(value)}" for a, value in zip("XYZ", moments, strict=True)),
        "quaternion": numbers(quaternion(axes), 9),
    }


def angles_of(rotation: np.ndarray) -> tuple[float, float, float]:
    """A, B, C [degrees] with rotation = Rz(A) Ry(B) Rx(C)."""
    c, b, a = np.degrees(pin.rpy.matrixToRpy(rotation)).tolist()
    return a, b, c


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """Unit quaternion of a rotation matrix, scalar first and not negative, shape (4,)."""
    x, y, z, w = pin.Quaternion(rotation).coeffs()
    vector = np.array([w, x, y, z])
    return vector * np.sign(vector[np.flatnonzero(np.abs(vector) > 1e-12)[0]])


def _xml_comment(text: str) -> str:
    return f"<!-- {xml_content(one_line(text)).replace('--', '- -')} -->"


FORMATS = {
    # https://www.universal-robots.com/manuals/EN/HTML/SW10_6/Content/prod-scriptmanual/G5/set_target_payload.htm
    # m [kg]; cog [m] from the tool mount; inertia [kg m^2] as Ixx, Iyy, Izz, Ixy, Ixz, Iyz, with its origin
    # in the center of gravity and axes along those of the tool flange. The same order as ur_msgs/SetPayload:
    # https://docs.ros.org/en/jazzy/p/ur_msgs/srv/SetPayload.html
    "ur": Form(
        "Call of set_target_payload: kg, m from the flange, kg m² about the center along the flange axes.",
        "set_target_payload({mass}, [{center}], [{inertia}])  {note}\n",
        hash_comment,
        ("tool0",),
    ),
    # https://docs.ros.org/en/humble/p/franka_msgs/srv/SetLoad.html: the 3 x 3 inertia is in column-major
    # order. https://raw.githubusercontent.com/frankarobotics/libfranka/main/include/franka/robot_state.h:
    # F_x_Cload [m] is the center of mass in the flange frame, I_load [kg m^2] is with respect to the center
    # of mass.
    "franka": Form(
        "Call of Robot::setLoad: kg, F_x_Cload in m, inertia in kg m² about the center, column-major.",
        "robot.setLoad({mass}, {{{center}}}, {{{inertia_columns}}});  {note}\n",
        cpp_comment,
        FRANKA,
    ),
    # https://www.easymanua.ls/kuka/iontec-kr-20-r3100/manual?p=40: M [kg]; center [mm]; the principal axes
    # follow from the reference axes by A about Z, then B about the new Y, then C about the new X [degrees];
    # moments about the principal axes through the center of mass [kg m^2].
    # https://infosys.beckhoff.com/content/1033/tf5120/13081587595.html: both relative to the flange; names M,
    # X, Y, Z, A, B, C, JX, JY, JZ.
    "kuka": Form(
        "LOAD_DATA: kg, mm and degrees from the flange, principal moments in kg m²; "
        "A, B, C about Z, Y', X''.",
        "LOAD_DATA[1]={{M {mass},CM {{{center_and_angles}}},J {{{named_moments}}}}}\n"
        "; JX, JY, JZ = {moments} kgm^2; LOAD_DATA[n] is the load of tool n\n"
        "{note}\n",
        krl_comment,
        ("tool0",),
    ),
    # http://docs.ros.org/en/noetic/api/abb_rapid_msgs/html/msg/LoadData.html and the RAPID reference
    # (https://www.yumpu.com/en/document/view/5679047/basic-characteristics-rapid/183): mass [kg]; cog [mm],
    # of a tool in the wrist coordinate system; aom, the principal axes at cog, as a quaternion q1 to q4 with
    # the scalar first; ix, iy, iz [kg m^2] about these axes.
    "abb": Form(
        "loaddata: kg, mm, quaternion of the principal axes (scalar first), principal moments in kg m².",
        "PERS loaddata tool_load := [{mass}, [{center_mm}], [{quaternion}], {moments}];  {note}\n",
        lambda text: f"! {one_line(text)}",
        ("tool0",),
    ),
    # https://wiki.ros.org/urdf/XML/link: mass [kg]; inertia [kg m^2] about the center of mass, in axes that
    # the origin gives; off-diagonal elements are minus the integral of x y.
    "urdf": Form(
        "Link to fix to the flange link: kg, m, kg m² about the center along the flange axes.",
        '{note}\n<link name="payload">\n'
        "  <inertial>\n"
        '    <origin xyz="{center_words}" rpy="0 0 0"/>\n'
        '    <mass value="{mass}"/>\n'
        "    <inertia {inertia_attributes}/>\n"
        "  </inertial>\n"
        "</link>\n",
        _xml_comment,
    ),
    # https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-inertial: pos [m] is the center of mass
    # in the body's frame; fullinertia [kg m^2] is about it in the order xx, yy, zz, xy, xz, yz.
    "mjcf": Form(
        "Body to put into the flange body: kg, m, kg m² about the center along the flange axes.",
        '{note}\n<body name="payload">\n'
        '  <inertial pos="{center_words}" mass="{mass}" fullinertia="{inertia_words}"/>\n'
        "</body>\n",
        _xml_comment,
    ),
}
"""Name of a controller or simulator -> its form."""


def is_own_flange(format: str, frame: str) -> bool:
    """Whether a form may refer to a frame: the controller's own flange, or `FLANGE`, a stated flange."""
    frames = FORMATS[format].frames
    return not frames or frame.lower().endswith(frames) or frame == FLANGE
