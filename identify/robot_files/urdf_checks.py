"""Checks of a URDF before its use."""

from collections import Counter
from collections.abc import Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from ..errors import BrokenTree, listed
from .kinematics import INERTIA_PLACES, check_center, inertia_doubt, inertia_matrix
from .toml_fields import LARGEST

MOVING = ("revolute", "continuous", "prismatic")
"""Types of joints with one degree of freedom."""
NUMBERED = (
    "xyz", "rpy", "value", "ixx", "ixy", "ixz", "iyy", "iyz", "izz", "lower", "upper", "velocity", "effort",
)  # fmt: skip
"""Attributes that hold numbers."""
HELD = "To hold it still, name the joints that move in a robot.toml: urdf = ..., joints = [...]"
DEEPEST = 100
"""Maximum depth of nested elements; recursive parsers fail at thousands."""


def read_tree(text: str, where: str) -> Element:
    """Root element of a URDF."""
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise BrokenTree(f"{where}: not well-formed XML: {error}") from error
    level, depth = [root], 0
    while level:
        level, depth = [inner for element in level for inner in element], depth + 1
        if depth > DEEPEST:
            raise BrokenTree(f"{where}: elements nested more than {DEEPEST} deep; a URDF has 5 levels")
    if root.tag != "robot":
        raise BrokenTree(f"{where}: the outermost element is <{root.tag}>, expected <robot>")
    macro = next((e.tag for e in root.iter() if "xacro" in str(e.tag)), None)
    if macro is not None:
        raise BrokenTree(
            f"{where}: contains xacro macros; expand it first (xacro robot.xacro > robot.urdf), "
            "or name it .xacro"
        )
    return root


def check_urdf(root: Element, where: str) -> None:
    """Refuse a URDF that is not one tree of links, or has invalid numbers."""
    _check_names(root, where)
    _check_tree(root, where)
    for element in root.iter():
        _check_numbers(element, where)
    for link in root.findall("link"):
        mass, origin = link.find("inertial/mass"), link.find("inertial/origin")
        if mass is not None and origin is not None:
            center = numbers_of(origin.get("xyz", "0 0 0"))
            check_center(float(mass.get("value", 0.0)), center, f"{where}: link '{link.get('name')}'")


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


def link_at(joint: Element, side: str) -> str:
    """Name of a joint's link on the side "parent" or "child"."""
    element = joint.find(side)
    return "" if element is None else element.get("link", "")


def _check_tree(root: Element, where: str) -> None:
    """Require one root, one parent per link, and no loops."""
    links = [link.get("name", "") for link in root.findall("link")]
    parent: dict[str, str] = {}
    for joint in root.findall("joint"):
        name = joint.get("name")
        for side in ("parent", "child"):
            if link_at(joint, side) not in links:
                raise BrokenTree(
                    f"{where}: joint '{name}' has {side} link '{link_at(joint, side)}', which does "
                    f"not exist. Links: {listed(links, link_at(joint, side))}"
                )
        child = link_at(joint, "child")
        if child in parent:
            raise BrokenTree(f"{where}: link '{child}' has two parents, the second through joint '{name}'")
        parent[child] = link_at(joint, "parent")
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
    """Require valid numbers, and masses that are not negative."""
    for key in NUMBERED:
        text = element.get(key)
        if text is None or element.tag not in ("origin", "axis", "mass", "inertia", "limit"):
            continue
        largest = np.inf if element.tag == "limit" else LARGEST
        values = attribute_numbers(element, key, 3 if key in ("xyz", "rpy") else 1, where, largest=largest)
        if element.tag == "mass" and values[0] < 0:
            raise BrokenTree(f"{where}: mass {text} kg; a mass is at least 0")


def attribute_numbers(
    element: Element, key: str, count: int, where: str, default: str = "", largest: float = np.inf
) -> np.ndarray:
    """Numbers of an attribute, finite and at most `largest` in size, shape (count,)."""
    text = element.get(key, default)
    try:
        values = numbers_of(text)
    except ValueError:
        values = np.empty(0)
    if len(values) != count or not np.all(np.isfinite(values) & (np.abs(values) <= largest)):
        raise BrokenTree(f'{where}: <{element.tag} {key}="{text}">: expected {count} finite number(s)')
    return values


def check_joint(joint: Element, where: str) -> None:
    """Refuse a joint that is neither fixed nor has one degree of freedom."""
    kind = joint.get("type")
    if kind not in (*MOVING, "fixed"):
        raise BrokenTree(f"{where} is {kind}; valid types: {', '.join(MOVING)}, fixed. {HELD}")
    if joint.find("mimic") is not None:
        raise BrokenTree(f"{where} mimics another joint, which no model can represent. {HELD}")
    if kind != "fixed" and not np.any(axis_of(joint)):
        raise BrokenTree(f"{where} has an axis of length 0")


def urdf_doubts(root: Element, where: str) -> Iterator[str]:
    """Doubts about the inertias of links, link by link."""
    for link in root.findall("link"):
        element = link.find("inertial/inertia")
        if element is not None:
            inertia = inertia_matrix([float(element.get(f"i{axes}", 0.0)) for axes in INERTIA_PLACES])
            if doubt := inertia_doubt(inertia, f"{where}: link '{link.get('name')}'"):
                yield doubt


def axis_of(joint: Element) -> np.ndarray:
    """Axis of a joint, not normalized, shape (3,)."""
    element = joint.find("axis")
    # the default that URDF defines
    return numbers_of("1 0 0" if element is None else element.get("xyz", "1 0 0"))


def numbers_of(text: str) -> np.ndarray:
    """Numbers of an attribute."""
    return np.array([float(word) for word in text.split()])
