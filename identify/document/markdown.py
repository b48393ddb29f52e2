"""A section of a document as Markdown, for Rerun's text panels."""

from functools import singledispatch

from ..text_table import raised
from .document import Block, Figure, Folded, Grid, Heading, Links, Paragraph, Section, Statements, Table
from .text import shortened


def section_markdown(section: Section) -> str:
    """The section as Markdown, without plots."""
    return raised("\n\n".join([f"## {section.title}", *filter(None, map(_block, section.blocks))]))


@singledispatch
def _block(block: Block) -> str:
    """Markdown of a block; empty for a plot."""
    raise TypeError(f"not a document block: {block!r}")


@_block.register
def _(block: Table) -> str:
    more, block = block.more, shortened(block)
    rule = "---|" * len(block.head)
    rows = [[f"**{row[0]}**", *[""] * (len(block.head) - 1)] if len(row) == 1 else row for row in block.rows]
    footer = ["", more] if more else []
    return "\n".join([_row(block.head), f"|{rule}", *map(_row, rows), *footer]) if rows else ""


def _row(cells: object) -> str:
    return f"| {' | '.join(str(cell).replace('|', '/') for cell in cells)} |"  # type: ignore[attr-defined]


@_block.register
def _(block: Statements) -> str:
    return "\n".join(f"- {sentence}" for sentence in block.sentences)


@_block.register
def _(block: Paragraph) -> str:
    return "" if block.style == "plot" else block.text


@_block.register
def _(block: Heading) -> str:
    return f"### {block.text}"


@_block.register
def _(block: Figure | Links | Folded) -> str:
    return ""


@_block.register
def _(block: Grid) -> str:
    return "\n\n".join(filter(None, map(_block, block.blocks)))
