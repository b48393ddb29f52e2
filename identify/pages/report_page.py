"""The frame of every report: one HTML page that needs nothing else, its contents and its chapters."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from markupsafe import Markup

from .report_html import TEMPLATES

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


def page(
    title: str, heading: str, note: str, body: str, chapters: Sequence[Chapter] = (), style: str = ""
) -> str:
    """A whole page: no script, no network, light and dark, fit to print.

    Args:
        title: Of the window, plain text.
        heading: Plain text.
        note: What stands below the heading, plain text.
        body: Sections, HTML.
        chapters: What follows them; those without sections are left out.
        style: CSS beyond that of every page.
    """
    return TEMPLATES.get_template("page.html").render(
        title=title,
        heading=heading,
        note=note,
        body=Markup(body),
        chapters=[_prefixed(chapter) for chapter in chapters if chapter.sections],
        headings=_headings,
        style=Markup(style),
    )


def _prefixed(chapter: Chapter) -> Chapter:
    sections = NAMED.sub(rf'<section id="{chapter.anchor}-\1"', str(chapter.sections))
    return chapter._replace(sections=Markup(sections))


def _headings(sections: str) -> list[tuple[str, Markup]]:
    return [(anchor, Markup(title)) for anchor, title in HEADING.findall(sections)]
