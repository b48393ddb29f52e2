"""Names that would break out of generated code, and an arm that is called by them."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from exidyn.identification.model import Model

from . import two_joints

NAMES = (
    "plain",
    'it\'s "quoted"',
    "triple \"\"\" quotes '''",
    '""" + __import__("builtins").exidyn_was_here() + """',
    "'); __import__('builtins').exidyn_was_here() #",
    "backslash \\ at the end\\",
    "line\nfeed\r\nand return\r",
    "\nEND\nHALT\n",
    "tab\tand \x00 nul \x1b[31m escape \x7f \x9b31m",
    "]]> <!-- <a b='c'/> &amp; & \" >",
    "; DEF other() ; # // /* */ %",
    "separators \u2028 \u2029 \x85 \x0b \x0c \x1c",
    "{name} {0} {{ }} {joints!r} ${evaluated} $(command) `command` %s %(name)s",
    "\u202egnitirw desrever \ufeff\u200b\ufffe\uffff",
    "ünïcödé 関節 \U0001f9be",
    "../../../outside",
    "",
)
"""The last is nothing at all."""
HALVES = ("half \ud800 pair", "bytes \udcff of a path")
"""What JSON and file names can hold and no encoding can: text of these cannot reach a model."""


def model(name: str, *more: str) -> Model:
    """The arm of two joints; robot, joints and links have these names, numbered where they would be equal."""
    of = two_joints.model()
    plain = name.replace("\0", "")
    kinematics = pin.Model()
    kinematics.name = plain
    parent = kinematics.addFrame(pin.Frame(f"{plain}base", 0, 0, pin.SE3.Identity(), pin.FrameType.BODY))
    arm = of.robot
    for place in range(arm.dof):
        offset = arm.kinematics.jointPlacements[place + 1]
        joint = kinematics.addJoint(place, pin.JointModelRY(), offset, f"{plain}{place}")
        kinematics.appendBodyToJoint(joint, arm.kinematics.inertias[place + 1], pin.SE3.Identity())
        frame = kinematics.addJointFrame(joint, parent)
        parent = kinematics.addBodyFrame(f"link {plain}{place}", joint, pin.SE3.Identity(), frame)
    return replace(of, robot=replace(arm, name=name, kinematics=kinematics))


def values(of: Model) -> np.ndarray:
    """A value for every parameter."""
    return two_joints.true_values(of)
