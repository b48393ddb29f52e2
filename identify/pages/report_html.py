"""Pieces of a report from the templates beside this file: text is escaped, `Markup` is HTML already."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

NAMELESS = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"


def number(value: float, digits: int = 4) -> Markup:
    """A number rounded for people; the element's value attribute has it in full."""
    value = float(value)
    if not np.isfinite(value):
        return Markup(NAMELESS)
    return Markup('<data value="{!r}">{}</data>').format(value, rounded(value, digits))


def rounded(value: float, digits: int = 4) -> str:
    """A value to so many significant digits, whole numbers in full, with a true minus sign."""
    if value == 0.0:
        return "0"
    size = int(np.floor(np.log10(abs(value))))
    if -4 < size < 6:
        shown = f"{value:.{max(0, digits - 1 - size)}f}"
    else:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        shown = f"{mantissa}e{int(exponent)}"
    return shown.replace("-", MINUS)


def unit(name: str) -> str:
    """A unit with raised exponents."""
    return name.replace("^2", "\N{SUPERSCRIPT TWO}").replace("^3", "\N{SUPERSCRIPT THREE}")


def prose(words: str) -> Markup:
    """Plain text whose per cent signs stay with their numbers."""
    return (
        escape(words)
        .replace(" %", "\N{NO-BREAK SPACE}%")
        .replace(" x noise", " \N{MULTIPLICATION SIGN} noise")
        .replace(" x its noise", " \N{MULTIPLICATION SIGN} its noise")
    )


TEMPLATES = Environment(
    loader=PackageLoader(__package__, ""),
    autoescape=True,
    undefined=StrictUndefined,
    keep_trailing_newline=True,
)
TEMPLATES.filters["prose"] = prose
_PARTS: Any = TEMPLATES.get_template("parts.html").module


def table(head: Sequence[str], rows: Iterable[Sequence[str]], words: Sequence[int] = ()) -> Markup:
    """A table; a cell may be a whole `<td ...>`.

    Args:
        head: Titles.
        rows: Cells of each row.
        words: Columns that hold words rather than numbers.
    """
    return _PARTS.table(head, rows, words)


def listing(lines: Iterable[str], style: str = "") -> Markup:
    """Sentences as a list."""
    return _PARTS.listing(lines, style)


def paragraph(words: str, style: str = "note") -> Markup:
    """A paragraph of plain text."""
    return Markup('<p class="{}">{}</p>').format(style, prose(words))


def heading(words: str) -> Markup:
    """A heading within a section."""
    return Markup("<h3>{}</h3>").format(words)


def figure(caption: str, remark: str, picture: str) -> Markup:
    """A picture, which is HTML, with its title above."""
    return _PARTS.figure(caption, remark, Markup(picture))


def grid(*parts: str, kind: str = "two") -> Markup:
    """Parts, which are HTML, side by side where the screen is wide."""
    return _PARTS.grid(map(Markup, parts), kind)


def section(anchor: str, title: str, *content: str) -> Markup:
    """A headed part of the page; the content is HTML."""
    return _PARTS.section(anchor, title, map(Markup, content))
