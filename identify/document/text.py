"""A document as text with 80 columns, for terminals."""

from collections.abc import Sequence

from ..text_table import at_point, page_width, paragraph, raised, table
from .document import (
    Block,
    Cell,
    Document,
    Figure,
    Folded,
    Grid,
    Heading,
    Number,
    Paragraph,
    Picture,
    Section,
    Statements,
    Table,
)

LABEL = 18
"""Width of the label of a fact [characters]."""


def text(document: Document) -> str:
    """The document as text, without plots and details."""
    width = page_width.get()
    parts = [[document.title.center(width).rstrip(), "=" * width, *_facts(document)]]
    parts += [
        [section.title, "-" * page_width.get(), *blocks_lines(section.blocks)] for section in short(document)
    ]
    return raised("\n\n".join("\n".join(part) for part in parts if part)) + "\n" + "=" * width


def short(document: Document) -> list[Section]:
    """Sections that have text and are not details."""
    return [one for one in document.sections if not one.detail and blocks_lines(one.blocks)]


def _facts(document: Document) -> list[str]:
    written = [
        line
        for label, value in document.facts
        for line in paragraph(value, " " * LABEL, f"{label + ':':<{LABEL}}")
    ]
    return (paragraph(document.note) if document.note else []) + written


def _lines(block: Block) -> list[str]:
    """Lines of a block; a plot has none."""
    match block:
        case Table():
            return _table_lines(block)
        case Statements(sentences):
            return [line for sentence in sentences for line in paragraph(sentence, "  ", "- ")]
        case Paragraph(words, style):
            return [] if style == "plot" else paragraph(words)
        case Heading(words):
            return ["", words]
        case Grid(blocks):
            return blocks_lines(blocks)
        case Figure() | Folded():
            return []


def blocks_lines(blocks: Sequence[Block]) -> list[str]:
    """Lines of blocks, without headings that have only plots below them."""
    written = [(block, _lines(block)) for block in blocks]
    return [
        line
        for index, (block, block_lines) in enumerate(written)
        if not isinstance(block, Heading) or _has_text(written[index + 1 :])
        for line in block_lines
    ]


def _has_text(written: Sequence[tuple[Block, list[str]]]) -> bool:
    """Whether a block before the next heading has text."""
    for block, block_lines in written:
        if isinstance(block, Heading):
            return False
        if block_lines:
            return True
    return False


def shortened(block: Table) -> Table:
    """The first rows of a table, without columns with drawings."""
    if block.first:
        block = block._replace(rows=block.rows[: block.first])
    drawn = {column for row in block.rows for column, cell in enumerate(row) if isinstance(cell, Picture)}
    if not drawn:
        return block
    shown = [column for column in range(len(block.head)) if column not in drawn]
    rows = [row if len(row) == 1 else [row[column] for column in shown] for row in block.rows]
    words = [shown.index(column) for column in block.words if column in shown]
    return Table([block.head[column] for column in shown], rows, words)


def _table_lines(block: Table) -> list[str]:
    """Lines of a table, with numbers aligned at their decimal points."""
    more, block = block.more, shortened(block)
    if not block.rows:
        return []
    full_rows = [row for row in block.rows if len(row) == len(block.head)]
    columns = [_aligned([row[column] for row in full_rows]) for column in range(len(block.head))]
    cells = iter(zip(*columns, strict=True))
    rows = [list(next(cells)) if len(row) == len(block.head) else [str(row[0])] for row in block.rows]
    return table(block.head, rows, left=[0, *block.words]) + ([more] if more else [])


def _aligned(cells: list[Cell]) -> list[str]:
    """Cells as text; a column of numbers without units is aligned at the decimal point."""
    texts = [str(cell) for cell in cells]
    plain = [place for place, cell in enumerate(cells) if isinstance(cell, Number) and not cell.unit]
    if len(plain) == len(cells):
        return at_point(texts)
    return texts


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
