"""A document as text with 80 columns, for terminals."""

from collections.abc import Collection, Sequence

from ..text_table import at_point, page_width, paragraph, raised, table
from .document import (
    Block,
    Cell,
    Code,
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
    parts = [[document.title.center(width).rstrip(), "=" * width]]
    parts[0] += paragraph(document.note) + fact_lines(document.facts, "", LABEL)
    for section in document.sections:
        if not section.detail and (lines := blocks_lines(section.blocks)):
            parts.append([section.title, "-" * width, *lines])
    return raised("\n\n".join("\n".join(part) for part in parts)) + "\n" + "=" * width


def brief_text(document: Document, room: int) -> str:
    """The short form of the document as text of at most `room` lines, as far as sentences can be left out.

    Tables, verdicts, the first sentence, and what was asked for in addition are shown in full; the number of
    left-out sentences is stated.
    """
    in_full = [not isinstance(block, Statements) or block.style == "verdict" for block in document.brief]
    parts = {place: _lines(b) for place, b in enumerate(document.brief) if in_full[place]}
    # The title, its rule, the number of left-out sentences, and a blank line before each block.
    used = 3 + sum(
        1 + len(lines)
        for place, lines in parts.items()
        if isinstance(document.brief[place], Table | Statements)
    )
    for place, block in enumerate(document.brief):
        if isinstance(block, Statements) and not in_full[place]:
            shown, left_out = _fitting(block, room - used)
            used += len(shown)
            parts[place] = [*shown, *([f"  and {left_out} more: --full"] if left_out else [])]
    blocks = ("\n".join(parts[place]) for place in sorted(parts) if parts[place])
    return raised(f"{document.title}\n{'=' * page_width.get()}\n" + "\n\n".join(blocks))


def _fitting(block: Statements, room: int) -> tuple[list[str], int]:
    """Lines of the first sentence and of those after it that fit, and the number of the others."""
    lines: list[str] = []
    for place, sentence in enumerate(block.sentences):
        more = _lines(Statements([sentence]))
        if lines and len(lines) + len(more) > room:
            return lines, len(block.sentences) - place
        lines += more
    return lines, 0


def fact_lines(facts: Collection[tuple[str, str]], indent: str = "  ", width: int = 0) -> list[str]:
    """Lines of labels and values; the labels have this width with their colon, or that of the longest."""
    width = width or max((len(label) + 2 for label, _ in facts), default=2)
    lines = []
    for label, value in facts:
        lines += paragraph(value, indent + " " * width, f"{indent}{label + ':':<{width}}")
    return lines


def _lines(block: Block) -> list[str]:
    """Lines of a block; a plot has none."""
    match block:
        case Table():
            return _table_lines(block)
        case Statements(sentences):
            return [line for sentence in sentences for line in paragraph(sentence, "  ", "- ")]
        case Paragraph(words, style):
            return [] if style == "plot" else paragraph(words)
        case Code(program):
            return program.rstrip().splitlines()
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


def without_drawings(block: Table) -> Table:
    """The table without columns with drawings."""
    drawn = {column for row in block.rows for column, cell in enumerate(row) if isinstance(cell, Picture)}
    return block.only(*(column for column in range(len(block.head)) if column not in drawn))


def _table_lines(block: Table) -> list[str]:
    """Lines of a table, with numbers aligned at their decimal points."""
    block = without_drawings(block)
    if not block.rows:
        return []
    full_rows = [row for row in block.rows if len(row) == len(block.head)]
    columns = [_aligned([row[column] for row in full_rows]) for column in range(len(block.head))]
    cells = iter(zip(*columns, strict=True))
    rows = [list(next(cells)) if len(row) == len(block.head) else [str(row[0])] for row in block.rows]
    return table(block.head, rows, left=[0, *block.words])


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
        case Code(program):
            return f"```\n{program.rstrip()}\n```"
        case Heading(text):
            return f"### {text}"
        case Grid(blocks):
            return "\n\n".join(filter(None, map(_block, blocks)))
        case Figure() | Folded():
            return ""


def _table(block: Table) -> str:
    block = without_drawings(block)
    rule = "---|" * len(block.head)
    rows = [[f"**{row[0]}**", *[""] * (len(block.head) - 1)] if len(row) == 1 else row for row in block.rows]
    return "\n".join([_row(block.head), f"|{rule}", *map(_row, rows)]) if rows else ""


def _row(cells: Sequence[object]) -> str:
    return f"| {' | '.join(str(cell).replace('|', '/') for cell in cells)} |"
