"""Result of a command: printed for a person or for scripts, and shown in Rerun's viewer."""

from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exidyn.identification.document.document import Document
from exidyn.identification.document.text import brief_text, text

from ..terminal.json_output import hand_over, json_text, print_next, print_written

if TYPE_CHECKING:
    from ..views.viewers import View

LINES = 25
"""Lines that a command prints by default, which a terminal shows without scrolling."""


@dataclass(frozen=True)
class Result:
    """What a command returns."""

    # Text or document for a person; None if the result consists of its files or its view.
    page: str | Document | None = None
    # The result for scripts, or the text of its JSON, which --json prints or writes.
    table: Mapping[str, Any] | str = ""
    written: Sequence[Path] = ()  # files that the command wrote
    report: Path | None = None  # HTML page of the document, which is written too; the folder exists
    next: Sequence[str] = ()  # commands that usually follow
    # Function that makes the view of --view, --serve and --save, and imports Rerun.
    view: "Callable[[], View] | None" = None

    def deliver(self, args: Namespace) -> None:
        """Write the report, print the result, and show its view, as the command line states."""
        written = self.written
        if self.report is not None and isinstance(self.page, Document):
            from exidyn.identification.document.html import html  # imports Jinja

            self.report.write_text(html(self.page), encoding="utf-8")
            written = [*written, self.report]
        if self.page is not None:
            content = self.table if isinstance(self.table, str) else json_text(dict(self.table))
            page = self.page
            if isinstance(page, Document):
                page = text(page) if args.full else brief_text(page, LINES - len(written) - len(self.next))
            hand_over(page, content, args.json)
        if written:
            print_written(*written)
        print_next(*self.next)
        if self.view is not None and (args.view or args.save or getattr(args, "serve", None)):
            from ..views.live_view import Targets
            from ..views.viewers import show

            show(self.view(), Targets(args.view, getattr(args, "serve", None), args.save))
            if args.save:
                print_written(args.save)


def later(name: str, *content: object) -> "Callable[[], View]":
    """Function that makes the view of views/NAME.py; it imports Rerun, which takes a second."""
    return lambda: getattr(import_module(f"..views.{name}", __package__), name)(*content)
