"""A section of a document as Markdown, for Rerun's text panels."""

from collections.abc import Sequence

from ..text_table import raised
from .document import Block, Figure, Folded, Grid, Heading, Paragraph, Section, Statements, Table
from .text import shortened


def section_markdown(section: Section) -> str:
    """The section as Markdown, without plots."""
    return raised("\n\n".join([f"## {section.title}", *filter(None, map(_block, section.blocks))]))


def _block(block: Block) -> str:
    """Markdown of a block; empty for a plot."""
    match block:
        case Table():
            return _table(block)
        case Statements(sentences):
            return "\n".join(f"- {sentence}" for sentence in sentences)
        case Paragraph(text, style):
            return "" if style == "plot" else text
        case Heading(text):
            return f"### {text}"
        case Grid(blocks):
            return "\n\n".join(filter(None, map(_block, blocks)))
        case Figure() | Folded():
            return ""


def _table(block: Table) -> str:
    more, block = block.more, shortened(block)
    rule = "---|" * len(block.head)
    rows = [[f"**{row[0]}**", *[""] * (len(block.head) - 1)] if len(row) == 1 else row for row in block.rows]
    footer = ["", more] if more else []
    return "\n".join([_row(block.head), f"|{rule}", *map(_row, rows), *footer]) if rows else ""


def _row(cells: Sequence[object]) -> str:
    return f"| {' | '.join(str(cell).replace('|', '/') for cell in cells)} |"
