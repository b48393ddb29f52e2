"""Text inside generated files: one function per language, which turns any text into data, never into code.

Names of robots, joints and links come from files of other people and may contain anything. Code that writes
Python, C++, XML, TOML, YAML, JSON or KRL passes each text through the function of that language. URScript has
no function because its programs contain only numbers.
"""

import json
import re
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

CONTROL = re.compile(
    r"[\x00-\x1f\x7f-\x9f\u00ad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f\ud800-\udfff\ufdd0-\ufdef"
    r"\ufeff\ufff9-\ufffb\ufffe\uffff]"
)
"""Control and format characters, line separators, lone surrogates (also from bytes of a path that are not
UTF-8) and noncharacters: a terminal would obey them, a parser refuse them, or a reader not see them."""
KRL_NAME = 24
"""Longest name of a KRL module [characters]."""
KRL_LINE = 80
"""Longest comment in a KRL program [characters]: the length of a line on the pendant."""


def one_line(text: str) -> str:
    r"""The text with each control character as its code, such as `\x1b`; it stays on one line."""
    return CONTROL.sub(lambda match: _code(match[0]), text)


def visible(text: str) -> str:
    """The text with each control character except line feeds and tabs as its code, for a terminal."""
    return CONTROL.sub(lambda match: match[0] if match[0] in "\n\t" else _code(match[0]), text)


def _code(character: str) -> str:
    number = ord(character)
    return f"\\x{number:02x}" if number < 0x100 else f"\\u{number:04x}"


def python_text(text: str) -> str:
    """A Python literal that evaluates to the text."""
    return ascii(text)


def double_quoted(text: str) -> str:
    """A string of TOML or YAML, whose double-quoted strings have the same escapes."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    plain = "".join(c if c.isprintable() else f"\\U{ord(_encodable(c)):08x}" for c in escaped)
    return f'"{plain}"'


def _encodable(character: str) -> str:
    """The character, or the replacement character for a lone surrogate, which no encoding can represent."""
    return "\ufffd" if "\ud800" <= character <= "\udfff" else character


def json_text(value: Any, indent: int | None = 1) -> str:
    """JSON of plain values, with control characters escaped so that it can be printed to a terminal."""
    text = json.dumps(value, indent=indent, ensure_ascii=False, allow_nan=False)
    # Line feeds and tabs within texts are escaped already; the remaining ones are layout.
    return CONTROL.sub(lambda match: match[0] if match[0] in "\n\t" else f"\\u{ord(match[0]):04x}", text)


def xml_document(root: Element, declaration: bool = True) -> str:
    """An indented XML document; characters that XML cannot hold are written as their codes."""
    for element in root.iter():
        element.attrib = {key: one_line(value) for key, value in element.attrib.items()}
        if element.text and (element.text.strip() or not len(element)):  # else it is indentation
            element.text = one_line(element.text)
    ElementTree.indent(root)
    head = '<?xml version="1.0"?>\n' if declaration else ""
    return head + ElementTree.tostring(root, encoding="unicode") + "\n"


def xml_content(text: str) -> str:
    """Text between two tags."""
    return one_line(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def xml_attribute(text: str, quote: str = '"') -> str:
    """The value of an attribute, with its quotes."""
    return quote + xml_content(text).replace(quote, {'"': "&quot;", "'": "&apos;"}[quote]) + quote


def krl_name(text: str) -> str:
    """A name that KRL accepts, after `exidyn_`: letters, digits and underscores."""
    plain = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")
    return f"exidyn_{plain}"[:KRL_NAME]


def krl_comment(text: str) -> str:
    """A comment of a KRL program: one line of ASCII, which every controller reads."""
    return f";{one_line(text).encode('ascii', 'replace').decode()}"[:KRL_LINE]


def hash_comment(text: str) -> str:
    """A comment of YAML, TOML or Python, on one line."""
    return f"# {one_line(text)}"


def cpp_text(text: str) -> str:
    """A string of C++ in UTF-8, whose escapes have three octal digits so that none runs into the next."""
    plain = "".join(
        chr(byte) if 0x20 <= byte < 0x7F and chr(byte) not in '"\\?' else f"\\{byte:03o}"
        for byte in text.encode("utf-8", "replace")
    )
    return f'"{plain}"'


def cpp_name(text: str) -> str:
    """A name that C++ accepts, after `exidyn_`: letters, digits and single underscores."""
    plain = re.sub(r"[\W_]+", "_", text, flags=re.ASCII).strip("_")
    return f"exidyn_{plain}".rstrip("_")


def cpp_comment(text: str) -> str:
    """A comment of C++ on one line of ASCII; a backslash at its end would continue it."""
    plain = one_line(text).replace("\\", "/").encode("ascii", "replace").decode()
    return f"// {plain.replace('??', '? ?')}"
