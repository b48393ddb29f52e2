"""Edits of an XML text that preserve every other byte."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat

from exidyn.quoting import xml_attribute

from ..errors import RobotError
from ..robot_files.mjcf_elements import actuators, name_of

ATTRIBUTE = re.compile(
    rb"""(?P<before>\s+)(?P<name>[^\s=/>]+)(?P<between>\s*=\s*)(?P<quoted>"[^"]*"|'[^']*')"""
)
TAG = re.compile(rb"""<[^\s/>]+(?:\s+[^\s=/>]+\s*=\s*(?:"[^"]*"|'[^']*'))*\s*/?>""")


@dataclass
class Tag:
    """A start tag."""

    name: str  # name of the element
    start: int  # offset in the text [bytes]
    attributes: dict[str, str]  # attributes with resolved entities
    children: "list[Tag]" = field(default_factory=list)  # elements inside the element


def read_tags(text: bytes, where: str) -> Tag:
    """Root element; raises `RobotError` if the text is not XML, or is encoded without tags in ASCII."""
    parser, open_ = expat.ParserCreate(), [Tag("", 0, {})]

    def begin(name: str, attributes: dict[str, str]) -> None:
        tag = Tag(name, parser.CurrentByteIndex, attributes)
        open_[-1].children.append(tag)
        open_.append(tag)

    parser.StartElementHandler = begin
    parser.EndElementHandler = lambda name: open_.pop()
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise RobotError(f"{where}: not well-formed XML: {error}") from error
    [root] = open_[0].children
    if not text.startswith(b"<" + root.name.encode(), root.start):
        raise RobotError(f"{where}: not UTF-8; write it as UTF-8")
    return root


class Edits:
    """Changes of a text, collected and then applied together."""

    def __init__(self, text: bytes) -> None:
        self._text = text
        self._attributes: dict[int, dict[str, tuple[str, str] | None]] = {}
        self._inside: dict[int, list[str]] = {}

    def set(self, tag: Tag, **attributes: str | None) -> None:
        """Set attributes of a start tag; None removes an attribute."""
        changes = self._attributes.setdefault(tag.start, {})
        changes.update({name: None if value is None else (name, value) for name, value in attributes.items()})

    def replace(self, tag: Tag, old: str, new: str, value: str) -> None:
        """Replace an attribute of a start tag by another one."""
        self._attributes.setdefault(tag.start, {})[old] = new, value

    def add_inside(self, tag: Tag, element: str) -> None:
        """Insert an element before the first one inside a tag, on its own line if that one is."""
        self._inside.setdefault(tag.start, []).append(element)

    def __bool__(self) -> bool:
        return bool(self._attributes or self._inside)

    def text(self) -> bytes:
        """The text with the changes."""
        text = self._text
        for start in sorted({*self._attributes, *self._inside}, reverse=True):
            end = _end(text, start)
            tag = _with_attributes(text[start:end], self._attributes.get(start, {}))
            before_next = re.match(rb"\s*", text[end:])
            space = before_next.group() if before_next else b""
            inside = self._inside.get(start, [])
            added = b"".join(space + element.encode() for element in inside)
            if inside and tag.endswith(b"/>"):  # an element without content
                name = re.split(rb"[\s/]", tag[1:], maxsplit=1)[0]
                tag, added = tag[:-2].rstrip() + b">", "".join(inside).encode() + b"</" + name + b">"
            text = text[:start] + tag + added + text[end:]
        return text


def element_text(name: str, attributes: Mapping[str, str]) -> str:
    """An element without content."""
    return f"<{name} {' '.join(f'{key}={xml_attribute(value)}' for key, value in attributes.items())}/>"


def element_end(text: bytes, tag: Tag) -> int:
    """Offset of the end of an element without content [bytes]."""
    end = _end(text, tag.start)
    closing = re.compile(rb"\s*</[^>]*>").match(text, end)
    return end if text[end - 2 : end] == b"/>" or closing is None else closing.end()


def _end(text: bytes, start: int) -> int:
    """Offset of the end of a start tag."""
    match = TAG.match(text, start)
    if match is None:  # impossible: expat has accepted the tag
        raise AssertionError(text[start : start + 40])
    return match.end()


def _with_attributes(tag: bytes, attributes: dict[str, tuple[str, str] | None]) -> bytes:
    pending = dict(attributes)

    def replaced(match: "re.Match[bytes]") -> bytes:
        name = match["name"].decode()
        if name not in pending:
            return match.group()
        value = pending.pop(name)
        if value is None:
            return b""
        new, text = value
        quoted = xml_attribute(text, match["quoted"][:1].decode())
        return match["before"] + new.encode() + match["between"] + quoted.encode()

    tag = ATTRIBUTE.sub(replaced, tag)
    close = re.search(rb"\s*/?>$", tag)
    at = close.start() if close else len(tag)
    new = "".join(f" {value[0]}={xml_attribute(value[1])}" for value in pending.values() if value is not None)
    return tag[:at] + new.encode() + tag[at:]


class Elements:
    """Start tags of bodies, joints and actuators, by their indices in the compiled model."""

    def __init__(self, root: Tag, model: Any, where: str) -> None:
        self.root, self._model, self._where = root, model, where
        bodies = [tag for world in root.children if world.name == "worldbody" for tag in _bodies(world)]
        joints = [tag for body in bodies for tag in _joints(body)]
        self._tags = {"body": bodies, "joint": joints, "actuator": actuator_tags(root)}

    def tag(self, kind: str, index: int) -> Tag:
        """The tag of a "body", "joint" or "actuator"; body 0 is the world and has none.

        Raises `RobotError` if it is in an included file or replicated.
        """
        if tag := self.find(kind, index):
            return tag
        name = name_of(self._model, kind, index)
        raise RobotError(
            f"{self._where}: {kind} '{name}' is not in the text of this file, but in an included file, or "
            "created by replicate or attach. Give the file that contains it"
        )

    def find(self, kind: str, index: int) -> Tag | None:
        """The tag with an element's name, or at its place if that tag has no name and none is elsewhere."""
        model, tags = self._model, self._tags[kind]
        if named := [tag for tag in tags if tag.attributes.get("name") == name_of(model, kind, index)]:
            return named[0]
        counts = {"body": model.nbody - 1, "joint": model.njnt, "actuator": len(actuators(model))}
        place = index - (kind == "body")
        complete = len(tags) == counts[kind]
        return tags[place] if complete and "name" not in tags[place].attributes else None

    @property
    def degrees(self) -> bool:
        """Whether angles are in degrees, MuJoCo's default."""
        units = [tag.attributes["angle"] for tag in self.root.children if "angle" in tag.attributes]
        return not units or units[-1] == "degree"


def actuator_tags(root: Tag) -> list[Tag]:
    """Actuators of an MJCF."""
    return [tag for part in root.children if part.name == "actuator" for tag in part.children]


def _bodies(tag: Tag) -> Iterator[Tag]:
    """Bodies inside a tag, in MuJoCo's order."""
    for child in tag.children:
        if child.name == "body":
            yield child
        if child.name in ("body", "frame"):
            yield from _bodies(child)


def _joints(tag: Tag) -> Iterator[Tag]:
    """Joints that belong directly to a body."""
    for child in tag.children:
        if child.name in ("joint", "freejoint"):
            yield child
        elif child.name == "frame":
            yield from _joints(child)
