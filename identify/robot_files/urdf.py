"""URDF: kinematics, inertias and limits, through Pinocchio, after a check that names what is wrong."""

from collections import Counter
from collections.abc import Collection, Mapping
from types import MappingProxyType
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from ..arm.robot import Limits
from ..errors import BrokenTree, listed
from .held_joints import MOVING, axis_of, hold
from .kinematics import INERTIA_PLACES, Kinematics, rigid_inertia
from .plausible import check_urdf_centers, urdf_doubts
from .toml_fields import LARGEST

FLANGES = ("flange", "tool0", "tool_flange", "ee_link", "end_effector", "tcp", "link_ee")
"""Names (or ends of names) of links that people hang payloads on, the likeliest first."""
NUMBERED = (
    "xyz", "rpy", "value", "ixx", "ixy", "ixz", "iyy", "iyz", "izz", "lower", "upper", "velocity", "effort",
)  # fmt: skip
"""Attributes that hold numbers."""
FAR = 1e300
"""A limit that urdfdom can read and no joint reaches; it knows no infinity."""

HELD = "To hold it still, name the joints that move in a robot.toml: urdf = ..., joints = [...]"
DEEPEST = 100
"""Elements within elements; parsers that call themselves for each level end at thousands."""


def parse_urdf(
    text: str,
    where: str = "URDF",
    moving: Collection[str] | None = None,
    held: Mapping[str, float] = MappingProxyType({}),
) -> Kinematics:
    """Kinematics of a URDF; a `continuous` joint becomes a revolute one without limits.

    Args:
        text: The URDF.
        where: What errors call it.
        moving: Joints that move; the others are held where their position is zero. None: all but `held`.
        held: Joints that are held elsewhere, and where [rad, m].

    Raises:
        BrokenTree: It is not one tree of joints with one degree of freedom; the message names the culprit.
        UnknownJoint: One of `moving` or `held` is not in it.
    """
    root = _parse(text, where)
    joints = {joint.get("name", ""): joint for joint in root.findall("joint")}
    _check_names(root, where)
    _check_tree(root, where)
    for element in root.iter():
        _check_numbers(element, where)
    check_urdf_centers(root, where)
    hold(joints, moving, held, where)
    for name, joint in joints.items():
        _check_joint(joint, f"{where}: joint '{name}'")
    limits = {name: _limits(joint) for name, joint in joints.items()}
    for joint in joints.values():
        _make_plain(joint)
    for link in root.findall("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)  # for `read_geometry`; urdfdom prints complaints of shapes it does not know
    model = _load(ElementTree.tostring(root, encoding="unicode"), where)
    described = _gather(limits, tuple(model.names)[1:])
    return Kinematics(model, described, _flange(model, root), doubts=tuple(urdf_doubts(root, where)))


def movable_joints(text: str, where: str = "URDF") -> tuple[list[str], list[str]]:
    """Joints of a URDF that are not fixed: those that a model can have, and those that have to be held.

    Raises:
        BrokenTree: It is no URDF.
    """
    free: list[str] = []
    bound: list[str] = []
    for joint in _parse(text, where).findall("joint"):
        if joint.get("type") != "fixed":
            plain = joint.get("type") in MOVING and joint.find("mimic") is None
            (free if plain else bound).append(joint.get("name", ""))
    return free, bound


def _parse(text: str, where: str) -> Element:
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise BrokenTree(f"{where}: not well-formed XML: {error}") from error
    _check_depth(root, where)
    if root.tag != "robot":
        raise BrokenTree(f"{where}: the outermost element is <{root.tag}>, expected <robot>")
    macro = next((e.tag for e in root.iter() if "xacro" in str(e.tag)), None)
    if macro is not None:
        raise BrokenTree(
            f"{where}: contains xacro macros; expand it first (xacro robot.xacro > robot.urdf), "
            "or name it .xacro"
        )
    return root


def _check_depth(root: Element, where: str) -> None:
    level, depth = [root], 0
    while level:
        level, depth = [inner for element in level for inner in element], depth + 1
        if depth > DEEPEST:
            raise BrokenTree(f"{where}: elements within elements, more than {DEEPEST} deep; URDF has 5")


def _check_names(root: Element, where: str) -> None:
    for kind in ("link", "joint"):
        names = [element.get("name", "") for element in root.findall(kind)]
        if "" in names:
            raise BrokenTree(f"{where}: a {kind} has no name")
        twice = [name for name, count in Counter(names).items() if count > 1]
        if twice:
            raise BrokenTree(f"{where}: {kind} name used twice: {listed(twice)}")
    if not root.findall("link"):
        raise BrokenTree(f"{where}: there is no link")


def _end(joint: Element, side: str) -> str:
    element = joint.find(side)
    return "" if element is None else element.get("link", "")


def _check_tree(root: Element, where: str) -> None:
    """One root, one parent a link, no loop."""
    links = [link.get("name", "") for link in root.findall("link")]
    parent: dict[str, str] = {}
    for joint in root.findall("joint"):
        name = joint.get("name")
        for side in ("parent", "child"):
            if _end(joint, side) not in links:
                raise BrokenTree(
                    f"{where}: joint '{name}' has {side} link '{_end(joint, side)}', which does "
                    f"not exist. Links: {listed(links, _end(joint, side))}"
                )
        child = _end(joint, "child")
        if child in parent:
            raise BrokenTree(f"{where}: link '{child}' has two parents, the second through joint '{name}'")
        parent[child] = _end(joint, "parent")
    for link in links:
        _check_reaches_root(link, parent, where)
    roots = [link for link in links if link not in parent]
    if len(roots) > 1:
        raise BrokenTree(f"{where}: {len(roots)} roots, expected one: {listed(roots)}")


def _check_reaches_root(link: str, parent: dict[str, str], where: str) -> None:
    path = [link]
    while path[-1] in parent:
        above = parent[path[-1]]
        if above in path:
            raise BrokenTree(
                f"{where}: links form a loop: {' <- '.join([*path[path.index(above) :], above])}"
            )
        path.append(above)


def _check_numbers(element: Element, where: str) -> None:
    """Every number a number, and masses not negative."""
    for key in NUMBERED:
        text = element.get(key)
        if text is None or element.tag not in ("origin", "axis", "mass", "inertia", "limit"):
            continue
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            values = []
        expected = 3 if key in ("xyz", "rpy") else 1
        known = np.isfinite(values) if element.tag == "limit" else np.abs(values) <= LARGEST
        if len(values) != expected or not np.all(known):
            raise BrokenTree(f'{where}: <{element.tag} {key}="{text}">: expected {expected} finite number(s)')
        if element.tag == "mass" and values[0] < 0:
            raise BrokenTree(f"{where}: mass {text} kg; a mass is at least 0")


def _check_joint(joint: Element, where: str) -> None:
    kind = joint.get("type")
    if kind not in (*MOVING, "fixed"):
        raise BrokenTree(f"{where} is {kind}; valid types: {', '.join(MOVING)}, fixed. {HELD}")
    if joint.find("mimic") is not None:
        raise BrokenTree(f"{where} mimics another joint, which no model here can. {HELD}")
    if kind != "fixed" and not np.any(axis_of(joint)):
        raise BrokenTree(f"{where} has an axis of length 0")


def _limits(joint: Element) -> tuple[float, float, float, float]:
    """Lower, upper, velocity, effort; an absent or zero limit, which would freeze the joint, is none."""
    element = joint.find("limit")
    get = {} if element is None else element.attrib
    lower, upper = float(get.get("lower", 0)), float(get.get("upper", 0))
    if joint.get("type") == "continuous" or lower == upper:
        lower, upper = -np.inf, np.inf
    velocity, effort = float(get.get("velocity", 0)), float(get.get("effort", 0))
    return lower, upper, velocity if velocity > 0 else np.inf, effort if effort > 0 else np.inf


def _make_plain(joint: Element) -> None:
    """A joint as Pinocchio gives it one position: revolute or prismatic, unit axis, limits present."""
    if joint.get("type") not in MOVING:
        return
    joint.set("type", "prismatic" if joint.get("type") == "prismatic" else "revolute")
    axis = axis_of(joint)
    length = np.linalg.norm(axis)
    if abs(length - 1.0) > 1e-12:
        for element in joint.findall("axis"):
            joint.remove(element)
        ElementTree.SubElement(joint, "axis", xyz=" ".join(repr(float(x)) for x in axis / length))
    for element in joint.findall("limit"):
        joint.remove(element)
    far = repr(FAR)
    ElementTree.SubElement(joint, "limit", lower=f"-{far}", upper=far, velocity=far, effort=far)


def _load(text: str, where: str) -> pin.Model:
    try:
        model = pin.buildModelFromXML(text)
    except (RuntimeError, ValueError) as error:
        first = (str(error).strip() or "no reason given").splitlines()[0]
        raise BrokenTree(f"{where}: {first}") from error
    if model.nv == 0:
        raise BrokenTree(f"{where}: no joint moves; at least one must be {', '.join(MOVING)}")
    for name, body in zip(list(model.names)[1:], list(model.inertias)[1:], strict=True):
        six = np.array([body.inertia[at] for at in INERTIA_PLACES])
        rigid_inertia(body.mass, body.lever, six, f"{where}: body moved by joint '{name}'")
    return model


def _gather(limits: dict[str, tuple[float, float, float, float]], joints: tuple[str, ...]) -> Limits:
    lower, upper, velocity, effort = np.array([limits[joint] for joint in joints]).T
    unlimited = np.full(len(joints), np.inf)
    return Limits(lower, upper, velocity, unlimited, unlimited, effort)


def _flange(model: pin.Model, root: Element) -> pin.SE3:
    """Placement, in the last joint's frame, of the leaf link that is called like a flange."""
    parents = {_end(joint, "parent") for joint in root.findall("joint")}
    leaves = {
        frame.name: frame.placement
        for frame in model.frames
        if frame.type == pin.FrameType.BODY
        and frame.parentJoint == model.njoints - 1
        and frame.name not in parents
    }
    for ending in FLANGES:
        for name, placement in leaves.items():
            if name.lower().endswith(ending):
                return pin.SE3(placement)
    return pin.SE3.Identity()
