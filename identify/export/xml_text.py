"""Edits of an XML text that preserve every other byte."""

import re
from dataclasses import dataclass, field
from xml.parsers import expat

from exidyn.quoting import xml_attribute

from ..errors import RobotError

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
            added = b"".join(space + element.encode() for element in self._inside.get(start, []))
            text = text[:start] + tag + added + text[end:]
        return text


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
