"""A document as a single HTML page: printable, light and dark, without scripts or network access."""

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from exidyn.quoting import visible

from ..text_table import UNKNOWN, digits, raised
from .document import Block, Cell, Document, Marked, Number, Numbers, Picture

NAMELESS = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"


def html(document: Document, style: str = "") -> str:
    """The HTML page of a document, with additional CSS."""
    page = TEMPLATES.get_template("page.html").render(
        document=document,
        sections=[section for section in document.sections if section.blocks],
        style=Markup(style),
    )
    return visible(page)


def prose(words: str) -> Markup:
    """Plain text with typographic symbols, and percent signs that stay with their numbers."""
    return (
        escape(words)
        .replace(" %", "\N{NO-BREAK SPACE}%")
        .replace(" x noise", " \N{MULTIPLICATION SIGN} noise")
        .replace(" x its noise", " \N{MULTIPLICATION SIGN} its noise")
        .replace("-&gt;", "\N{RIGHTWARDS ARROW}")
        .replace("+-", "\N{PLUS-MINUS SIGN}")
    )


def cell(content: Cell) -> Markup:
    """HTML of a cell."""
    match content:
        case str():
            return Markup(NAMELESS) if content == UNKNOWN else prose(raised(content))
        case Number():
            return _number(content)
        case Numbers(pattern, numbers):
            return Markup(prose(pattern)).format(*map(cell, numbers))
        case Marked():
            return cell(content.cell)
        case Picture(svg):
            return Markup(svg)


def _number(number: Number) -> Markup:
    shown = digits(number.value, number.digits)
    if shown == UNKNOWN:
        return Markup(NAMELESS)
    suffix = f" {raised(number.unit)}" if number.unit else ""
    pattern = Markup('<data value="{!r}">{}</data>{}')
    return pattern.format(float(number.value), shown.replace("-", MINUS), prose(suffix))


def block(content: Block) -> Markup:
    """HTML of a block, by the macro in parts.html that has the name of its class."""
    macro: Any = getattr(_PARTS, type(content).__name__.lower())
    return Markup(macro(content))


TEMPLATES = Environment(
    loader=PackageLoader(__package__, ""),
    autoescape=True,
    undefined=StrictUndefined,
    keep_trailing_newline=True,
)
TEMPLATES.filters |= {"prose": prose, "cell": cell, "block": block}
_PARTS = TEMPLATES.get_template("parts.html").module
