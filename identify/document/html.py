"""A document as one HTML page: no script, no network, light and dark, fit to print."""

from functools import singledispatch
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from exidyn.quoting import visible

from ..text_table import UNKNOWN, digits
from .document import (
    Block,
    Cell,
    Chapter,
    Document,
    Figure,
    Grid,
    Heading,
    Link,
    Links,
    Marked,
    Number,
    Numbers,
    Paragraph,
    Picture,
    Statements,
    Table,
)

NAMELESS = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"


def html(document: Document, style: str = "") -> str:
    """The whole page.

    Args:
        document: What it says.
        style: CSS beyond that of every page.
    """
    chapters = [_numbered(chapter) for chapter in document.chapters]
    page = TEMPLATES.get_template("page.html").render(
        document=document,
        sections=[section for section in document.sections if section.blocks],
        chapters=[chapter for chapter in chapters if chapter.sections],
        style=Markup(style),
    )
    return visible(page)


def _numbered(chapter: Chapter) -> Chapter:
    """The chapter with anchors that are its own on the page."""
    sections = [
        one._replace(anchor=f"{chapter.anchor}-{one.anchor}") for one in chapter.sections if one.blocks
    ]
    return chapter._replace(sections=sections)


def prose(words: str) -> Markup:
    """Plain text whose per cent signs stay with their numbers."""
    return (
        escape(words)
        .replace(" %", "\N{NO-BREAK SPACE}%")
        .replace(" x noise", " \N{MULTIPLICATION SIGN} noise")
        .replace(" x its noise", " \N{MULTIPLICATION SIGN} its noise")
        .replace("-&gt;", "\N{RIGHTWARDS ARROW}")
        .replace("+-", "\N{PLUS-MINUS SIGN}")
    )


def unit(name: str) -> str:
    """A unit with raised exponents."""
    return name.replace("^2", "\N{SUPERSCRIPT TWO}").replace("^3", "\N{SUPERSCRIPT THREE}")


@singledispatch
def cell(content: Cell) -> Markup:
    """Content of a cell."""
    raise TypeError(f"no cell of a table: {content!r}")


@cell.register
def _(content: str) -> Markup:
    return Markup(NAMELESS) if content == UNKNOWN else prose(unit(content))


@cell.register
def _(content: Number) -> Markup:
    shown = digits(content.value, content.digits)
    if shown == UNKNOWN:
        return Markup(NAMELESS)
    behind = f" {unit(content.unit)}" if content.unit else ""
    whole = Markup('<data value="{!r}">{}</data>{}')
    return whole.format(float(content.value), shown.replace("-", MINUS), prose(behind))


@cell.register
def _(content: Numbers) -> Markup:
    return Markup(prose(content.pattern)).format(*map(cell, content.numbers))


@cell.register
def _(content: Marked) -> Markup:
    return cell(content.cell)


@cell.register
def _(content: Link) -> Markup:
    return Markup('<a href="{}">{}</a>').format(content.address, content.words)


@cell.register
def _(content: Picture) -> Markup:
    return Markup(content.svg)


@singledispatch
def block(content: Block) -> Markup:
    """A block of a section."""
    raise TypeError(f"no block of a document: {content!r}")


@block.register
def _(content: Table) -> Markup:
    return _PARTS.table(content, {0, *content.words})


@block.register
def _(content: Statements) -> Markup:
    return _PARTS.statements(content)


@block.register
def _(content: Paragraph) -> Markup:
    style = "note" if content.style == "plot" else content.style
    return Markup('<p class="{}">{}</p>').format(style, prose(content.text))


@block.register
def _(content: Links) -> Markup:
    return Markup('<p class="note">{}</p>').format(Markup(", ").join(map(cell, content.links)))


@block.register
def _(content: Heading) -> Markup:
    return Markup("<h3>{}</h3>").format(content.text)


@block.register
def _(content: Figure) -> Markup:
    return _PARTS.figure(content, Markup(content.svg))


@block.register
def _(content: Grid) -> Markup:
    return _PARTS.grid(content) if content.blocks else Markup()


def _templates() -> Environment:
    environment = Environment(
        loader=PackageLoader(__package__, ""),
        autoescape=True,
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    environment.filters |= {"prose": prose, "cell": cell, "block": block}
    return environment


TEMPLATES = _templates()
_PARTS: Any = TEMPLATES.get_template("parts.html").module
