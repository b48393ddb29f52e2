"""A document as a single HTML page: printable, light and dark, without scripts or network access."""

from functools import singledispatch
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from exidyn.quoting import visible

from ..text_table import UNKNOWN, digits, raised
from .document import (
    Block,
    Cell,
    Chapter,
    Document,
    Figure,
    Folded,
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
    """The HTML page of a document.

    Args:
        document: Content of the page.
        style: Additional CSS.
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
    """The chapter, with anchors that are unique on the page."""
    sections = [
        section._replace(anchor=f"{chapter.anchor}-{section.anchor}")
        for section in chapter.sections
        if section.blocks
    ]
    return chapter._replace(sections=sections)


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


@singledispatch
def cell(content: Cell) -> Markup:
    """HTML of a cell."""
    raise TypeError(f"not a table cell: {content!r}")


@cell.register
def _(content: str) -> Markup:
    return Markup(NAMELESS) if content == UNKNOWN else prose(raised(content))


@cell.register
def _(content: Number) -> Markup:
    shown = digits(content.value, content.digits)
    if shown == UNKNOWN:
        return Markup(NAMELESS)
    suffix = f" {raised(content.unit)}" if content.unit else ""
    pattern = Markup('<data value="{!r}">{}</data>{}')
    return pattern.format(float(content.value), shown.replace("-", MINUS), prose(suffix))


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
    """HTML of a block."""
    raise TypeError(f"not a document block: {content!r}")


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


@block.register
def _(content: Folded) -> Markup:
    parts = Markup().join(map(block, content.blocks))
    return Markup("<details><summary>{}</summary>{}</details>").format(content.title, parts)


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
