"""Document: statements, tables and plots of a result, with unrounded numbers, for several renderers."""

from collections.abc import Sequence
from typing import NamedTuple

from ..text_table import UNKNOWN, digits


class Number(NamedTuple):
    """A number in a table."""

    value: float  # the value; NaN if it is unknown
    digits: int = 4  # number of significant digits to show; integers are shown in full
    unit: str = ""  # unit to show after the value; empty if the column header has it

    def __str__(self) -> str:
        shown = digits(self.value, self.digits)
        return f"{shown} {self.unit}" if self.unit and shown != UNKNOWN else shown


class Numbers(NamedTuple):
    """Several numbers in one cell, with words between them, such as "{} ± {}"."""

    pattern: str
    numbers: tuple[Number, ...]

    def __str__(self) -> str:
        return self.pattern.format(*self.numbers)


class Marked(NamedTuple):
    """A cell with a judgment, "good", "middling" or "bad", and its meaning."""

    cell: "str | Number"
    kind: str
    meaning: str = ""

    def __str__(self) -> str:
        return str(self.cell)


class Picture(NamedTuple):
    """A drawing (SVG) in a cell; text and Markdown leave out columns with drawings."""

    svg: str


Cell = str | Number | Numbers | Marked | Picture


Row = Sequence[Cell]


class Table(NamedTuple):
    """A table."""

    head: Sequence[str]  # titles of the columns
    rows: Sequence[Row]  # rows of cells; a row of one cell is a heading within the table
    words: Sequence[int] = ()  # indices of columns of words besides the first; all others hold numbers

    def only(self, *columns: int) -> "Table":
        """The table with these columns; headings within it stay."""
        rows = [row if len(row) == 1 else [row[column] for column in columns] for row in self.rows]
        words = [place for place, column in enumerate(columns) if column in self.words]
        return self._replace(head=[self.head[column] for column in columns], rows=rows, words=words)

    def beside(self, other: "Table") -> "Table":
        """This table and the columns of another with the same rows, without its first column."""
        rows = [[*row, *further[1:]] for row, further in zip(self.rows, other.rows, strict=True)]
        words = [*self.words, *(len(self.head) - 1 + column for column in other.words)]
        return self._replace(head=[*self.head, *other.head[1:]], rows=rows, words=words)


class Statements(NamedTuple):
    """Sentences, the most important first; the style "verdict" highlights them."""

    sentences: Sequence[str]
    style: str = ""


class Paragraph(NamedTuple):
    """A paragraph; its style is "note" for explanations, or "plot" for notes that only concern plots."""

    text: str
    style: str = "note"


class Code(NamedTuple):
    """Lines for a program or a controller, which are not wrapped."""

    text: str


class Heading(NamedTuple):
    """A heading within a section."""

    text: str


class Figure(NamedTuple):
    """A plot (SVG) with its caption and a remark."""

    caption: str
    remark: str
    svg: str


class Grid(NamedTuple):
    """Blocks side by side if there is room; the kind is the CSS class that arranges them."""

    blocks: "Sequence[Block]"
    kind: str = "two"


class Folded(NamedTuple):
    """Blocks that a reader of the page opens by a click on the title; text and Markdown leave them out."""

    title: str
    blocks: "Sequence[Block]"


Block = Table | Statements | Paragraph | Code | Heading | Figure | Grid | Folded


class Section(NamedTuple):
    """A section with a heading."""

    anchor: str  # anchor for links to the section
    title: str  # title of the section
    blocks: Sequence[Block]  # blocks in reading order; a section without blocks is left out
    detail: bool = False  # whether text and Markdown leave it out


class Document(NamedTuple):
    """A page on one result."""

    title: str  # title of the page
    note: str  # one line below the title; empty for none
    sections: Sequence[Section]  # sections in reading order
    facts: Sequence[tuple[str, str]] = ()  # short labels and values at the top of the page
    brief: Sequence[Block] = ()  # blocks of the short form: verdict and one table
