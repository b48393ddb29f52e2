"""Commands of exidyn in this process: what they print and how long they take, and the check of logs."""

import contextlib
import io
import json
import re
import shlex
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from exidyn.acquire.command_line import main
from exidyn.identification.model import Model
from exidyn.identification.plausible.gate import suspect
from exidyn.identification.recordings.recording import Recording


class Output(NamedTuple):
    """What a command did."""

    code: int  # Exit code; 0 where it succeeded
    out: str  # Standard output
    err: str  # Standard error
    seconds: float  # CPU time [s]

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


class Claim(NamedTuple):
    """What the check says about recordings."""

    text: str  # The sentence that a person reads
    probability: float  # Stated probability of that sentence
    refuses: bool  # Whether identify refuses the recordings because of it


PRINTED = re.compile(r"(\S.{0,300}?) \(probability (?:>|above)? ?([\d.]+) %\)")
"""How a statement with its probability is printed."""
AS_RECORDED = "--as-recorded"
"""Stands in every refusal by the check, which this option takes back."""


def claims_in(text: str) -> list[Claim]:
    """All statements with a probability that a command printed on standard error, each once."""
    claims = {}
    for line in text.splitlines():
        for sentence, percent in PRINTED.findall(line):
            sentence = sentence.removeprefix("warning: ").removeprefix("exidyn: ")
            claims[sentence] = Claim(
                f"{sentence} {line[line.find(sentence) :]}", float(percent) / 100, AS_RECORDED in line
            )
    return list(claims.values())


def claims_about(runs: Sequence[Recording], model: Model) -> list[Claim]:
    """All statements of the check about recordings of one arm."""
    suspicion = suspect(runs, model)
    if suspicion is None or suspicion.probability is None:
        return []
    return [Claim(str(suspicion), suspicion.probability, False)]
