"""Telegrams that a KUKA controller sends every cycle, and the answers that it expects.

They are XML in ASCII, without a declaration and not always well formed (an attribute may be called 01), so
regular expressions read them. A fast pattern is made from the first telegram; a slow pattern, which allows
any order, reads telegrams that do not match it. Neither raises for any bytes.
"""

import math
import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from exidyn.quoting import xml_attribute

from .config import OWN, Element

STAMP = "IPOC"
"""Name of the controller's clock in a telegram [ms]; answers return it unchanged."""
LONGEST = 8192
"""Maximum length of a telegram [bytes]: 64 channels and all internal values take about 4000."""
LEARN = 100
"""Number of telegrams of another form after which a new form is learned, which takes a quarter of a cycle."""
DECIMALS = 6
"""Number of decimals of corrections: a millionth of a degree, below the resolution of any encoder."""

_ELEMENT = re.compile(rb'<([A-Za-z][\w.:-]*)((?:\s+[\w.:-]+\s*=\s*"[^"]*")*)\s*(?:/>|>([^<]*))')
_ATTRIBUTE = re.compile(rb'([\w.:-]+)\s*=\s*"([^"]*)"')
_NUMBER = rb"([-+]?[0-9]+(?:\.[0-9]*)?(?:[eE][-+]?[0-9]{1,3})?)"
_WHOLE = rb"([0-9]{1,18})"
_WHOLE_TELEGRAM = re.compile(rb"\s*<Rob\b.*</Rob>[\s\0]*", re.DOTALL).fullmatch
_IS_NUMBER, _IS_WHOLE = re.compile(_NUMBER), re.compile(_WHOLE)


class Telegram(NamedTuple):
    """One telegram: its stamp IPOC, the stamp as a number [ms], and the requested values in their units."""

    stamp: bytes
    time: int
    numbers: tuple[float, ...]


class _Value(NamedTuple):
    """Position of a value in a telegram."""

    name: str
    start: int
    stop: int


class TelegramReader:
    """Reads the same values of every telegram: `element.attribute`, `element` for its text, and the stamp."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = (*names, STAMP)
        self._form: _Form | None = None
        self._unlike = 0

    def read(self, data: bytes) -> Telegram | None:
        """Read a telegram; None for bytes that are not a telegram or lack a name."""
        texts = self._form.texts(data) if self._form else None
        texts = texts or self._search(data)
        if texts is None:
            return None
        numbers = tuple(map(float, texts[:-1]))
        # A finite sum has only finite terms; checking it takes a fraction of the time.
        return Telegram(texts[-1], int(texts[-1]), numbers) if math.isfinite(sum(numbers)) else None

    def missing(self, data: bytes) -> list[str]:
        """Names that are missing in a telegram."""
        there = {value.name for value in _values(data)}
        return [name for name in self._names if name not in there]

    def _search(self, data: bytes) -> Sequence[bytes] | None:
        """Find the texts in the order of the names, and learn the form for later telegrams."""
        if not _WHOLE_TELEGRAM(data):
            return None
        values = _values(data)
        counts = Counter(value.name for value in values)
        if any(counts[name] != 1 for name in self._names):
            return None
        places = {value.name: value for value in values}
        texts = [data[places[name].start : places[name].stop] for name in self._names]
        if not all(map(_IS_NUMBER.fullmatch, texts)) or not _IS_WHOLE.fullmatch(texts[-1]):
            return None
        if self._unlike % LEARN == 0:
            self._form = _Form(data, values, self._names)
        self._unlike += 1
        return texts


class _Form:
    """Form of a telegram, which matches telegrams with other numbers."""

    def __init__(self, data: bytes, values: Sequence[_Value], names: Sequence[str]) -> None:
        pattern, last = b"", 0
        for value in values:
            wanted = _WHOLE if value.name == STAMP else _NUMBER
            pattern += re.escape(data[last : value.start])
            pattern += wanted if value.name in names else rb'[^"<>]*'
            last = value.stop
        order = [value.name for value in values if value.name in names]
        self._match = re.compile(pattern + re.escape(data[last:])).fullmatch
        self._places = tuple(order.index(name) + 1 for name in names)

    def texts(self, data: bytes) -> Sequence[bytes] | None:
        """Texts in the order of the names; None for a telegram of another form."""
        match = self._match(data)
        return match.group(*self._places, 0)[:-1] if match else None


def _values(data: bytes) -> list[_Value]:
    """All attributes and texts in their order."""
    values: list[_Value] = []
    if len(data) > LONGEST:
        return values
    for element in _ELEMENT.finditer(data):
        name = element[1].decode("ascii", "replace")
        for attribute in _ATTRIBUTE.finditer(data, *element.span(2)):
            text = attribute[1].decode("ascii", "replace")
            values.append(_Value(f"{name}.{text}", *attribute.span(2)))
        if element[3] and element[3].strip():
            start = element.start(3) + len(element[3]) - len(element[3].lstrip())
            values.append(_Value(name, start, start + len(element[3].strip())))
    return values


def decimals(data: bytes, element: str) -> int:
    """Maximum number of decimals among the attributes of an element; zero if it is missing."""
    texts = [data[v.start : v.stop] for v in _values(data) if v.name.startswith(f"{element}.")]
    return max((len(text.partition(b".")[2]) for text in texts), default=0)


class Answer:
    """Writes answers with corrections and one switch; all other values that the controller expects are zero.

    `corrections` are tags in the order of `head`, and `switch` is the tag that is 1 when the arm should stop,
    empty without one.
    """

    def __init__(
        self, sentype: str, receive: Sequence[Element], corrections: Sequence[str], switch: str = ""
    ) -> None:
        fields = {tag: f"%({tag}).{DECIMALS}f" for tag in corrections} | {switch: f"%({switch})d"}
        groups: dict[str, dict[str, str]] = {}
        for element in receive:
            if not element.tag.startswith(OWN):
                first, _, second = element.tag.partition(".")
                groups.setdefault(first, {})[second] = fields.get(element.tag, _NOTHING[element.kind])
        note = "<EStr></EStr>" * any(element.tag == f"{OWN}EStr" for element in receive)
        body = "".join(_element(name, group) for name, group in groups.items())
        begin = f"<Sen Type={xml_attribute(sentype)}>".replace("%", "%%")
        self._template = f"{begin}{note}{body}<{STAMP}>".encode()
        self._tags = tuple(tag.encode() for tag in corrections)
        self._switch = switch.encode()

    def head(self, corrections: Sequence[float], stop: bool = False) -> bytes:
        """Part of an answer that does not depend on the telegram, and can be written before it arrives."""
        return self._template % {**dict(zip(self._tags, corrections, strict=True)), self._switch: stop}

    def complete(self, head: bytes, stamp: bytes) -> bytes:
        return head + stamp + _END


_END = f"</{STAMP}></Sen>".encode()
_NOTHING = {"BOOL": "0", "LONG": "0", "DOUBLE": "0.0000", "STRING": ""}


def _element(name: str, attributes: dict[str, str]) -> str:
    if "" in attributes:
        return f"<{name}>{attributes['']}</{name}>"
    inside = " ".join(f'{second}="{field}"' for second, field in attributes.items())
    return f"<{name} {inside}/>"
