"""A known fit, and a reader of the pages that reports are."""

import re
from functools import cache
from html.parser import HTMLParser

import numpy as np

from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify

from ...identify.fit.test_identify import BODY, record


@cache
def known_fit() -> Fit:
    """Of the two-joint arm, with a known payload and a run held out."""
    return identify([record(0), record(1, payload=BODY)], validate=[record(5)])


class Page(HTMLParser):
    """Elements of a page; fails where tags do not close in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.elements, self.rows, self.data, self.words = [], [], {}, [], ""
        self.section, self.value = "", None
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.elements.append((tag, attrs))
        if tag == "meta":
            return
        self.open.append(tag)
        if tag == "section":
            self.section = attrs["id"]
        if tag == "tr":
            self.rows.setdefault(self.section, []).append([])
        if tag == "td":
            self.rows[self.section][-1].append(("", []))
        if tag == "data":
            self.value = attrs["value"]

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, words):
        self.words += words
        if self.open and self.open[-1] == "data":
            self.data.append((float(self.value), words))
        if "td" in self.open and "svg" not in self.open:
            text, values = self.rows[self.section][-1][-1]
            more = [float(self.value)] if self.open[-1] == "data" else []
            self.rows[self.section][-1][-1] = (text + words, values + more)

    def row(self, section, first):
        """The row of a section that starts with this word."""
        found = [row for row in self.rows[section] if row and row[0][0] == first]
        assert len(found) == 1, (section, first)
        return found[0]


def points_of(steps):
    """Vertices of a path as our module writes it, shape (k, 2) in tenths of pixels."""
    start, rest = re.fullmatch(r"M(-?\d+ -?\d+)(?:l([\d \-]*)z?|h0)", steps).groups()
    numbers = [int(n) for n in re.findall(r"-?\d+", rest or "")]
    return np.cumsum([[int(n) for n in start.split()], *np.reshape(numbers, (-1, 2)).astype(int)], axis=0)


def dots_of(steps):
    return np.array([[int(n) for n in pair] for pair in re.findall(r"M(\d+) (\d+)h0", steps)])
