"""Command-line parser whose error messages are one line, and the exit codes of every command."""

import argparse
import sys
import textwrap
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

DONE, STOPPED, REFUSED, LOST, WRONG, UNSAFE = range(6)  # argparse too refuses with 2
INTERRUPTED, READER_LEFT = 130, 141  # by the convention of shells: 128 + SIGINT, 128 + SIGPIPE
MEANINGS = {
    DONE: "done",
    STOPPED: "a run of the arm was stopped early, or you did not type yes (record, jog)",
    REFUSED: "not done: an argument or a file is wrong or missing; one line on standard error names it",
    LOST: "done, but part of the recording is lost (info --repair)",
    WRONG: "done, but the joint does not behave as expected (jog)",
    UNSAFE: "after a run the arm still moves, or may: press the emergency stop (record, jog)",
    INTERRUPTED: "interrupted by Ctrl-C",
    READER_LEFT: "the reader of the output has closed it, as head does",
}
"""Exit code -> its meaning, for help and docs."""


MISSING = "the following arguments are required"
"""How argparse begins its message about missing arguments."""
WIDTH = 80
"""Width of help and messages, which every terminal shows [characters]."""


class CommandParser(argparse.ArgumentParser):
    """A parser that reports an error in one line, with the likely correction; usage text would hide it."""

    _words: Sequence[str] = ()

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse the arguments; the error for an unknown option names the nearest existing option."""
        self._words = list(sys.argv[1:] if args is None else args)
        parsed, unknown = self.parse_known_args(args, namespace)
        if unknown:
            self._refuse(unknown)
        return parsed

    def _refuse(self, unknown: Sequence[str]) -> NoReturn:
        """Report words that are unknown to this parser; the first is an option."""
        hint = nearest(unknown[0].partition("=")[0], self._option_string_actions)
        self.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")

    def error(self, message: str) -> NoReturn:
        """Print what is wrong and exit; if an argument is missing, name a misspelled option instead."""
        if message.startswith(MISSING):
            words = [word for word in self._words if word.startswith("--") and word != "--"]
            options = tuple(self._option_string_actions)
            # Words that look like options, but are neither an option nor the beginning of one.
            unknown = [w for w in words if not any(o.startswith(w.partition("=")[0]) for o in options)]
            if unknown:
                self._refuse(unknown)
        line = " ".join(message.split())
        line = f"{self.prog}: {line}{'' if line.endswith('?') else '.'} '{self.prog} --help' explains"
        self.exit(REFUSED, f"{complaint(line)}\n")


def nearest(text: str, valid: Iterable[str]) -> str:
    """The likely correction, as a question after an error message; empty if nothing is similar."""
    matches = get_close_matches(text, list(valid), 1)
    return f". Did you mean {matches[0]}?" if matches else ""


def complaint(line: str) -> str:
    """A message for standard error: one line for scripts, wrapped between words in a terminal."""
    if sys.stderr is None or not sys.stderr.isatty():
        return line
    return textwrap.fill(line, WIDTH, break_long_words=False, break_on_hyphens=False)
