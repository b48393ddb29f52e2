"""Document: statements, tables and plots of a result, with the numbers inside; renderers make pages of it."""

from collections.abc import Sequence
from typing import NamedTuple

from ..text_table import UNKNOWN, digits


class Number(NamedTuple):
    """A number in a table.

    Attributes:
        value: NaN where it is not known.
        digits: Significant digits that are shown; whole numbers are shown in full.
        unit: Shown behind it; empty where the head of the column has it.
    """

    value: float
    digits: int = 4
    unit: str = ""

    def __str__(self) -> str:
        shown = digits(self.value, self.digits)
        return f"{shown} {self.unit}" if self.unit and shown != UNKNOWN else shown


class Numbers(NamedTuple):
    """Several numbers in one cell, with words between them: "{} ± {}"."""

    pattern: str
    numbers: tuple[Number, ...]

    def __str__(self) -> str:
        return self.pattern.format(*self.numbers)


class Marked(NamedTuple):
    """A cell with a judgement: "good", "middling" or "bad", and what that means."""

    cell: "str | Number"
    kind: str
    meaning: str = ""

    def __str__(self) -> str:
        return str(self.cell)


class Link(NamedTuple):
    """Words that lead to an address; "#anchor" is that of a section."""

    words: str
    address: str

    def __str__(self) -> str:
        return self.words


class Picture(NamedTuple):
    """A drawing (SVG) in a cell; a column that has one is left out where nothing is drawn."""

    svg: str


Cell = str | Number | Numbers | Marked | Link | Picture


Row = Sequence[Cell]


class Table(NamedTuple):
    """A table.

    Attributes:
        head: Titles of the columns.
        rows: Cells; a row of one cell is a heading within the table.
        words: Columns of words beside the first; all others are numbers.
        first: Rows that short pages (text, Markdown) have; 0 for all.
    """

    head: Sequence[str]
    rows: Sequence[Row]
    words: Sequence[int] = ()
    first: int = 0

    @property
    def more(self) -> str:
        """What stands below a table of which a short page has the first rows alone; else empty."""
        left = len(self.rows) - self.first if self.first else 0
        return f"and {left} more in the report" if left > 0 else ""


class Statements(NamedTuple):
    """Sentences, the most important first; the style "verdict" makes them stand out."""

    sentences: Sequence[str]
    style: str = ""


class Paragraph(NamedTuple):
    """A text; the style "note" is that of explanations, "plot" that of notes about plots alone."""

    text: str
    style: str = "note"


class Links(NamedTuple):
    """A line of links, which only pages with links have."""

    links: Sequence[Link]


class Heading(NamedTuple):
    """A heading within a section."""

    text: str


class Figure(NamedTuple):
    """A plot (SVG) with its caption and a remark."""

    caption: str
    remark: str
    svg: str


class Grid(NamedTuple):
    """Blocks side by side where there is room; of how many columns, and whether their content is alike."""

    blocks: "Sequence[Block]"
    kind: str = "two"


Block = Table | Statements | Paragraph | Links | Heading | Figure | Grid


class Section(NamedTuple):
    """A headed part.

    Attributes:
        anchor: By which links lead to it.
        title: Title of the section.
        blocks: In the order in which they are read; without any, the section is left out.
        detail: Whether short pages (text, Markdown) leave it out.
    """

    anchor: str
    title: str
    blocks: Sequence[Block]
    detail: bool = False


class Chapter(NamedTuple):
    """Sections of one result among several on a page."""

    anchor: str
    title: str
    sections: Sequence[Section]


class Document(NamedTuple):
    """All that is said of one or several results.

    Attributes:
        title: Title of the page.
        note: One line below the title; empty for none.
        sections: In the order in which they are read.
        chapters: Chapters of further results.
        facts: Short labels and values that stand before everything else.
    """

    title: str
    note: str
    sections: Sequence[Section]
    chapters: Sequence[Chapter] = ()
    facts: Sequence[tuple[str, str]] = ()
