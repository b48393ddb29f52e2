"""The frame of every report: one HTML page that needs nothing else, its contents and its chapters."""

import re
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from .report_style import STYLE

HEADING = re.compile(r'<section id="([\w-]+)"><h2>(.*?)</h2>')
NAMED = re.compile(r'<section id="([\w-]+)"')


class Chapter(NamedTuple):
    """A part of a page that has sections of its own.

    Attributes:
        anchor: What links to it and to its sections begin with.
        title: Plain text.
        sections: HTML.
    """

    anchor: str
    title: str
    sections: str


def page(title: str, heading: str, note: str, body: str, contents: str = "") -> str:
    """A whole page: no script, no network, light and dark, fit to print.

    Args:
        title: Of the window, plain text.
        heading: Plain text.
        note: What stands below the heading, HTML.
        body: Sections, HTML.
        contents: Links to them, HTML; one to each section by default.
    """
    links = contents or f"<nav>{_links(body)}</nav>"
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head>"
        f'<body><h1>{escape(heading)}</h1><p class="note">{note}</p>{links}{body}</body></html>\n'
    )


def bound(opening: str, chapters: Sequence[Chapter]) -> tuple[str, str]:
    """Body and contents of a page of chapters; those without sections are left out.

    Args:
        opening: Sections before the first chapter.
        chapters: In their order.
    """
    body, rows = opening, [f"<li>{_links(opening)}</li>"] if opening else []
    for chapter in chapters:
        if not chapter.sections:
            continue
        sections = NAMED.sub(rf'<section id="{chapter.anchor}-\1"', chapter.sections)
        title = escape(chapter.title)
        body += f'<div class="chapter" id="{chapter.anchor}"><h1>{title}</h1>{sections}</div>'
        rows.append(f'<li><a class="part" href="#{chapter.anchor}">{title}</a>{_links(sections)}</li>')
    return body, f'<nav class="contents"><ol>{"".join(rows)}</ol></nav>'


def _links(body: str) -> str:
    return "".join(f'<a href="#{anchor}">{title}</a>' for anchor, title in HEADING.findall(body))
