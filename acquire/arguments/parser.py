"""How words of a command line are read, and how what is wrong with them is said: in one line."""

import argparse
import sys
import textwrap
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

from .exit_codes import REFUSED

MISSING = "the following arguments are required"
"""How argparse begins to say so."""
WIDTH = 80
"""Columns of a page: what every terminal shows."""


class CommandParser(argparse.ArgumentParser):
    """A parser whose complaint is one line, with what was probably meant; a page of usage would hide it."""

    _words: Sequence[str] = ()

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As of any parser; of an option that does not exist, the complaint names the nearest that does."""
        self._words = list(sys.argv[1:] if args is None else args)
        given, unknown = self.parse_known_args(args, namespace)
        if unknown:
            self._refuse(unknown)
        return given

    def _refuse(self, unknown: Sequence[str]) -> NoReturn:
        """Complain about words that this parser does not know, the first of them an option."""
        near = nearest(unknown[0].partition("=")[0], self._option_string_actions)
        self.error(f"unrecognized arguments: {' '.join(unknown)}{near}")

    def _unknown(self) -> list[str]:
        """Words that look like options and are none, nor the beginning of one."""
        words = [word for word in self._words if word.startswith("--") and word != "--"]
        options = tuple(self._option_string_actions)
        return [word for word in words if not any(one.startswith(word.partition("=")[0]) for one in options)]

    def error(self, message: str) -> NoReturn:
        """Print what is wrong, and end; where something is missing, a misspelt option may be why."""
        if message.startswith(MISSING) and (unknown := self._unknown()):
            self._refuse(unknown)
        line = " ".join(message.split())
        line = f"{self.prog}: {line}{'' if line.endswith('?') else '.'} '{self.prog} --help' explains"
        self.exit(REFUSED, f"{complaint(line)}\n")


def nearest(text: str, valid: Iterable[str]) -> str:
    """What was probably meant, as a question behind a complaint; empty where nothing is like it."""
    close = get_close_matches(text, list(valid), 1)
    return f". Did you mean {close[0]}?" if close else ""


def complaint(line: str) -> str:
    """A line for standard error: one for scripts, wrapped between words for a person."""
    if sys.stderr is None or not sys.stderr.isatty():
        return line
    return textwrap.fill(line, WIDTH, break_long_words=False, break_on_hyphens=False)
