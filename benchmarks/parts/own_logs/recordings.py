"""What init, import and the check say about public recordings: each set, each run, and each half."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from exidyn.identification.errors import ExidynError
from exidyn.identification.recordings.recording import Recording

from ..real.data import piece
from .commands import proposal_of, run
from .engine import claims_about
from .sets import RealSet
from .statements import Statement, of_init


def checked(data: RealSet, quick: bool) -> dict[str, Any]:
    """What import, the check and init say about a set: refusals, statements, and the seconds of init."""
    model, refused, statements, runs = data.model(), list[str](), list[Statement](), list[Recording]()
    names = data.runs[: 1 if quick else None]
    for name in names:
        try:
            runs.append(data.read(name, model))
        except ExidynError as error:
            refused.append(f"{data.name}/{name}: import: {error}")
    parts = dict(_parts(runs, quick))
    for name, part in parts.items():
        where = f"{data.name}/{name}"
        for claim in claims_about(part, model):
            true = data.verdict(claim.text)
            statements.append(Statement(where, claim.text, claim.probability, true))
            if claim.refuses and true is not True:
                refused.append(f"{where}: {claim.text}")
    proposals = [_proposed(data, name) for name in names[1:]]  # of the first run by the walk to a fit
    return {
        "set": data.name,
        "checked": len(parts),
        "refused": refused,
        "statements": [one._asdict() for one in (*statements, *(s for found, _ in proposals for s in found))],
        "seconds": {"init": max((seconds for _, seconds in proposals), default=0.0)},
    }


def _proposed(data: RealSet, run_name: str) -> tuple[list[Statement], float]:
    """Guesses of init about a run, and its CPU time."""
    with TemporaryDirectory() as folder:
        log, arm = data.copy(run_name, Path(folder))
        table = Path(folder) / "init.json"
        done = run("init", log, "--robot", arm, "-o", Path(folder) / "robot.toml", "--json", table)
        proposal = proposal_of(table)
    found = of_init(f"{data.folder}/{run_name}", proposal, data.known(run_name)) if proposal else []
    return found, done.seconds


def _parts(runs: Sequence[Recording], quick: bool) -> Iterator[tuple[str, list[Recording]]]:
    """The set as a whole and its halves in time, each run, and the halves of the first run."""
    halves = () if quick else (0, 1)
    if len(runs) > 1:
        yield "all runs", list(runs)
        for half in halves:
            yield f"half {half + 1} of all runs", [_half(recording, half) for recording in runs]
    for recording in runs:
        yield recording.name, [recording]
    for half in halves if runs else ():
        yield f"half {half + 1} of {runs[0].name}", [_half(runs[0], half)]


def _half(recording: Recording, half: int) -> Recording:
    return piece(recording, half, half + 1, 2, recording.name)
