"""URDF: kinematics, bodies, limits, and friction of each joint."""

from xml.etree import ElementTree
from xml.etree.ElementTree import SubElement

from ..robot_files.robot_text import urdf_text
from .portable import Portable

FEATURES = ("damping", "dry")


def urdf(portable: Portable) -> str:
    """Links as cylinders; `<dynamics>` has viscous and dry friction."""
    root = ElementTree.fromstring(urdf_text(portable.model))
    places = {name: place for place, name in enumerate(portable.robot.joints)}
    for joint in root.findall("joint"):
        if (place := places.get(joint.get("name", ""))) is not None:
            damping, friction = portable.joints.damping[place], portable.joints.dry[place]
            SubElement(joint, "dynamics", damping=repr(float(damping)), friction=repr(float(friction)))
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
