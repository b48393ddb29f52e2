"""Commands of exidyn in this process: what they print, how long they take, and the Next of init."""

import contextlib
import io
import json
import shlex
import time
from pathlib import Path
from typing import Any, NamedTuple

from exidyn.acquire.command_line import main


class Output(NamedTuple):
    """What a command did.

    Attributes:
        code: Exit code; 0 where it succeeded.
        out: Standard output.
        err: Standard error.
        seconds: CPU time [s].
    """

    code: int
    out: str
    err: str
    seconds: float

    @property
    def text(self) -> str:
        """All that was printed, with single spaces."""
        return " ".join(f"{self.out} {self.err}".split())


def run(*words: Any) -> Output:
    """Run one command."""
    out, err, begin = io.StringIO(), io.StringIO(), time.process_time()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main([str(word) for word in words])
        except SystemExit as end:
            code = int(end.code or 0)
    return Output(code, out.getvalue(), err.getvalue(), time.process_time() - begin)


def proposal_of(path: Path) -> dict[str, Any] | None:
    """JSON of init; None where init wrote none."""
    return json.loads(path.read_text()) if path.exists() else None


def run_next(proposal: dict[str, Any], folder: Path) -> str | None:
    """Run the Next of init into a folder: its error, "" where it succeeds, None where init printed none."""
    if not proposal["then"]:
        return None
    done = run(*shlex.split(proposal["then"])[1:], "-o", folder)
    return done.err.strip() if done.code else ""
