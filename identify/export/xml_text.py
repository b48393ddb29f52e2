"""Changes of an XML text that leave every other byte of it as it was."""

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
    """A start tag.

    Attributes:
        name: Of the element.
        start: Where it begins in the text [bytes].
        attributes: As written, entities resolved.
        children: Elements inside it.
    """

    name: str
    start: int
    attributes: dict[str, str]
    children: "list[Tag]" = field(default_factory=list)


def read_tags(text: bytes, where: str) -> Tag:
    """The outermost element of a text.

    Raises:
        RobotError: It is no XML, or not in an encoding in which tags are ASCII.
    """
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
    """Changes of a text, collected and then made at once."""

    def __init__(self, text: bytes) -> None:
        self._text = text
        self._attributes: dict[int, dict[str, tuple[str, str] | None]] = {}
        self._inside: dict[int, list[str]] = {}

    def set(self, tag: Tag, **attributes: str | None) -> None:
        """Give a start tag attributes; None takes one away."""
        own = self._attributes.setdefault(tag.start, {})
        own.update({name: None if value is None else (name, value) for name, value in attributes.items()})

    def replace(self, tag: Tag, old: str, new: str, value: str) -> None:
        """Put an attribute where a start tag has another one."""
        self._attributes.setdefault(tag.start, {})[old] = new, value

    def add_inside(self, tag: Tag, element: str) -> None:
        """Put an element before the first one inside a tag, on a line of its own if that is."""
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
            added = b"".join(space + one.encode() for one in self._inside.get(start, []))
            text = text[:start] + tag + added + text[end:]
        return text


def _end(text: bytes, start: int) -> int:
    """Where a start tag ends."""
    found = TAG.match(text, start)
    if found is None:  # expat has read it
        raise AssertionError(text[start : start + 40])
    return found.end()


def _with_attributes(tag: bytes, attributes: dict[str, tuple[str, str] | None]) -> bytes:
    left = dict(attributes)

    def replaced(found: "re.Match[bytes]") -> bytes:
        name = found["name"].decode()
        if name not in left:
            return found.group()
        value = left.pop(name)
        if value is None:
            return b""
        new, text = value
        quoted = xml_attribute(text, found["quoted"][:1].decode())
        return found["before"] + new.encode() + found["between"] + quoted.encode()

    tag = ATTRIBUTE.sub(replaced, tag)
    close = re.search(rb"\s*/?>$", tag)
    at = close.start() if close else len(tag)
    new = "".join(f" {value[0]}={xml_attribute(value[1])}" for value in left.values() if value is not None)
    return tag[:at] + new.encode() + tag[at:]
