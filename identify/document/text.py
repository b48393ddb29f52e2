"""A document as text of 80 columns, for terminals."""

from collections.abc import Sequence
from functools import singledispatch

from ..text_table import WIDTH, at_point, paragraph, table
from .document import (
    Block,
    Cell,
    Document,
    Figure,
    Grid,
    Heading,
    Links,
    Number,
    Paragraph,
    Picture,
    Section,
    Statements,
    Table,
)

LABEL = 18
"""Columns of the label of a fact."""


def text(document: Document) -> str:
    """The whole page, without plots and details."""
    parts = [[document.title.center(WIDTH).rstrip(), "=" * WIDTH, *_facts(document)]]
    parts += [_section(section) for section in short(document)]
    return "\n\n".join("\n".join(part) for part in parts if part) + "\n" + "=" * WIDTH


def short(document: Document) -> list[Section]:
    """Sections, those of chapters included, that have more than plots and are no details."""
    every = [*document.sections, *(one for chapter in document.chapters for one in chapter.sections)]
    return [section for section in every if not section.detail and blocks_lines(section.blocks)]


def _facts(document: Document) -> list[str]:
    written = [
        line
        for label, value in document.facts
        for line in paragraph(value, " " * LABEL, f"{label + ':':<{LABEL}}")
    ]
    return (paragraph(document.note) if document.note else []) + written


def _section(section: Section) -> list[str]:
    return [section.title, "-" * WIDTH, *blocks_lines(section.blocks)]


@singledispatch
def lines(block: Block) -> list[str]:
    """Lines of a block; none of a plot."""
    raise TypeError(f"no block of a document: {block!r}")


@lines.register
def _(block: Table) -> list[str]:
    return table_lines(block)


@lines.register
def _(block: Statements) -> list[str]:
    return [line for sentence in block.sentences for line in paragraph(sentence, "  ", "- ")]


@lines.register
def _(block: Paragraph) -> list[str]:
    return [] if block.style == "plot" else paragraph(block.text)


@lines.register
def _(block: Heading) -> list[str]:
    return ["", block.text]


@lines.register
def _(block: Figure | Links) -> list[str]:
    return []


@lines.register
def _(block: Grid) -> list[str]:
    return blocks_lines(block.blocks)


def blocks_lines(blocks: Sequence[Block]) -> list[str]:
    """Lines of blocks; headings of plots alone are left out."""
    written = [(block, lines(block)) for block in blocks]
    return [
        line
        for place, (block, own) in enumerate(written)
        if not isinstance(block, Heading) or _followed(written[place + 1 :])
        for line in own
    ]


def _followed(written: Sequence[tuple[Block, list[str]]]) -> bool:
    """Whether something is written before the next heading."""
    for block, own in written:
        if isinstance(block, Heading):
            return False
        if own:
            return True
    return False


def shortened(block: Table) -> Table:
    """The first rows of a table, without columns in which something is drawn."""
    if block.first:
        block = block._replace(rows=block.rows[: block.first])
    drawn = {place for row in block.rows for place, cell in enumerate(row) if isinstance(cell, Picture)}
    if not drawn:
        return block
    kept = [place for place in range(len(block.head)) if place not in drawn]
    rows = [row if len(row) == 1 else [row[place] for place in kept] for row in block.rows]
    words = [kept.index(place) for place in block.words if place in kept]
    return Table([block.head[place] for place in kept], rows, words)


def table_lines(block: Table) -> list[str]:
    """Lines of a table, numbers aligned at their decimal points."""
    more, block = block.more, shortened(block)
    if not block.rows:
        return []
    whole = [row for row in block.rows if len(row) == len(block.head)]
    columns = [_aligned([row[place] for row in whole]) for place in range(len(block.head))]
    cells = iter(zip(*columns, strict=True))
    rows = [list(next(cells)) if len(row) == len(block.head) else [str(row[0])] for row in block.rows]
    left = [0, *block.words]
    return table(block.head, rows, left=left) + ([more] if more else [])


def _aligned(cells: list[Cell]) -> list[str]:
    """Cells as text; numbers without a unit are padded to a common point."""
    texts = [str(cell) for cell in cells]
    plain = [place for place, cell in enumerate(cells) if isinstance(cell, Number) and not cell.unit]
    if len(plain) == len(cells):
        return at_point(texts)
    return texts
