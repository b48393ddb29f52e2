"""Pieces of a report: numbers that keep their full value, and tables."""

from collections.abc import Sequence
from html import escape

import numpy as np

NAMELESS = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"


def number(value: float, digits: int = 4) -> str:
    """A number rounded for people; the element's value attribute has it in full."""
    value = float(value)
    if not np.isfinite(value):
        return NAMELESS
    return f'<data value="{value!r}">{rounded(value, digits)}</data>'


def rounded(value: float, digits: int = 4) -> str:
    """A value to so many significant digits, whole numbers in full, with a true minus sign."""
    if value == 0.0:
        return "0"
    size = int(np.floor(np.log10(abs(value))))
    if -4 < size < 6:
        shown = f"{value:.{max(0, digits - 1 - size)}f}"
    else:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        shown = f"{mantissa}e{int(exponent)}"
    return shown.replace("-", MINUS)


def unit(name: str) -> str:
    """A unit with raised exponents."""
    return escape(name).replace("^2", "\N{SUPERSCRIPT TWO}")


def table(head: Sequence[str], rows: Sequence[Sequence[str]], words: Sequence[int] = ()) -> str:
    """A table of cells that are HTML already; a cell may be a whole `<td ...>`.

    Args:
        head: Titles, as plain text.
        rows: Cells of each row.
        words: Columns that hold words rather than numbers.
    """
    style = ['class="words"' if column in words else "" for column in range(len(head))]
    titles = "".join(
        f"<th {style[c]}>{escape(title)}</th>".replace(" >", ">") for c, title in enumerate(head)
    )
    body = "".join(f"<tr>{''.join(_cell(cell, style[c]) for c, cell in enumerate(row))}</tr>" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table></div>'


def _cell(cell: str, style: str) -> str:
    return cell if cell.startswith("<td") else f"<td {style}>{cell}</td>".replace(" >", ">", 1)


def listing(lines: Sequence[str], style: str = "") -> str:
    """Sentences as a list."""
    kind = f' class="{style}"' if style else ""
    return f"<ul{kind}>{''.join(f'<li>{prose(line)}</li>' for line in lines)}</ul>"


def prose(words: str) -> str:
    """Plain text whose per cent signs stay with their numbers."""
    return (
        escape(words)
        .replace(" %", "\N{NO-BREAK SPACE}%")
        .replace(" x noise", " \N{MULTIPLICATION SIGN} noise")
        .replace(" x its noise", " \N{MULTIPLICATION SIGN} its noise")
    )


def paragraph(words: str, style: str = "note") -> str:
    """A paragraph of plain text."""
    return f'<p class="{style}">{prose(words)}</p>'


def figure(caption: str, remark: str, picture: str) -> str:
    """A picture with its title above."""
    small = f"<small>{prose(remark)}</small>" if remark else ""
    return f"<figure><figcaption>{escape(caption)}{small}</figcaption>{picture}</figure>"


def section(anchor: str, title: str, *content: str) -> str:
    """A headed part of the page."""
    return f'<section id="{anchor}"><h2>{escape(title)}</h2>{"".join(content)}</section>'
