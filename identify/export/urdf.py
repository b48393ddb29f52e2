"""URDF that Pinocchio, PyBullet and Gazebo load as the same arm.

PyBullet takes a link without `<inertial>` as 1 kg, so frames without mass state a mass of 0. Gazebo drops
what moves on a link without mass, so the base, whose mass no torque depends on, has some and stands on
`world`.
"""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from exidyn.quoting import one_line, xml_document

from ..robot_files.robot_text import WORLD, urdf_text
from .portable import Portable

FEATURES = ("bodies", "damping", "dry")
BASE_MASS = 1.0
"""Mass [kg] and moments of inertia [kg m^2] of the base, which stands still."""
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def urdf(portable: Portable) -> str:
    """Links as cylinders, fixed to the world; viscous and dry friction in `<dynamics>`."""
    root = ElementTree.fromstring(urdf_text(portable.model))
    places = {one_line(name): place for place, name in enumerate(portable.robot.joints)}
    for joint in root.findall("joint"):
        if (place := places.get(joint.get("name", ""))) is not None:
            damping, friction = portable.joints.damping[place], portable.joints.dry[place]
            SubElement(joint, "dynamics", damping=repr(float(damping)), friction=repr(float(friction)))
    _state_masses(root)
    return xml_document(root)


def _state_masses(root: Element) -> None:
    """Put the base on the world, and give every other link an `<inertial>`."""
    children = {_end(joint, "child") for joint in root.findall("joint")}
    [first] = [str(link.get("name")) for link in root.findall("link") if link.get("name") not in children]
    if first != WORLD:
        _put_on_world(root, first)
    bases = {_end(joint, "child") for joint in root.findall("joint") if _end(joint, "parent") == WORLD}
    for link in root.findall("link"):
        if link.find("inertial") is None and link.get("name") != WORLD:
            _add_inertial(link, BASE_MASS if link.get("name") in bases else 0.0)


def _end(joint: Element, tag: str) -> str | None:
    """Name of a joint's parent or child link."""
    end = joint.find(tag)
    return None if end is None else end.get("link")


def _add_inertial(link: Element, mass: float) -> None:
    inertial = Element("inertial")
    SubElement(inertial, "mass", value=repr(mass))
    SubElement(inertial, "inertia", {name: repr(mass if name[1] == name[2] else 0.0) for name in MOMENTS})
    link.insert(0, inertial)


def _put_on_world(root: Element, base: str) -> None:
    root.insert(0, Element("link", name=WORLD))
    joint = Element("joint", name=f"{base}_fixed", type="fixed")
    SubElement(joint, "parent", link=WORLD)
    SubElement(joint, "child", link=base)
    root.append(joint)
