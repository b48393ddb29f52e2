"""Commands of exidyn in this process: what they print about a log, and whether that names a cure."""

import contextlib
import io
import json
import re
import shlex
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from exidyn.acquire.command_line import main
from exidyn.identification.model import Model
from exidyn.identification.plausible.gate import suspect
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.robot_text import urdf_text

from .arms import Columns, Scene
from .mistakes import INIT, WALK, Mistake
from .tables import Statement, altered, of_init


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


PRINTED = re.compile(r"(\S.{0,300}?) \(probability (?:>|above)? ?([\d.]+) %\)")
"""How a statement with its probability is printed."""


def claims_in(text: str) -> list[Claim]:
    """All statements with a probability that a command printed on standard error, each once."""
    claims = {}
    for line in text.splitlines():
        for sentence, percent in PRINTED.findall(line):
            sentence = sentence.removeprefix("warning: ").removeprefix("exidyn: ")
            claims[sentence] = Claim(f"{sentence} {line[line.find(sentence) :]}", float(percent) / 100)
    return list(claims.values())


def claims_about(runs: Sequence[Recording], model: Model) -> list[Claim]:
    """All statements of the check about recordings of one arm."""
    suspicion = suspect(runs, model)
    if suspicion is None or suspicion.probability is None:
        return []
    return [Claim(str(suspicion), suspicion.probability)]


WINDOW = 150
"""Characters on each side of the first word of a cure within which its other words must stand."""
SPAN = ".{0,80}"
"""What `.*` of a pattern may skip."""
BUILT_IN = ("cobot", "kr270")
KEPT = 500
"""Characters of each command's output that the figures keep."""


def names_cure(text: str, says: Sequence[str]) -> bool:
    """Whether all patterns of a cure stand close together in a text."""
    first, *others = (re.compile(pattern.replace(".*", SPAN), re.I) for pattern in says)
    return any(
        all(other.search(text, max(0, match.start() - WINDOW), match.end() + WINDOW) for other in others)
        for match in first.finditer(text)
    )


def walk_right(name: str, scene: Scene, only_init: bool = False) -> dict[str, Any]:
    """The three commands on a right log, what was said, and which statements are not true."""
    right = Mistake(name, dict, ("",), lambda: scene, steps=(INIT,) if only_init else WALK)
    with TemporaryDirectory() as folder:
        figures = _walk(right, scene, scene.columns, Path(folder))
    texts, statements = figures["texts"], figures.pop("claims")
    judged = [Statement(name, text, probability, False)._asdict() for text, probability in statements]
    refused = [f"{name}: {step}: {texts[step]}" for step, code in figures["codes"].items() if code]
    return figures | {"log": name, "statements": figures["statements"] + judged, "refused": refused}


def walk_mistake(mistake: Mistake, right: Mapping[str, str]) -> dict[str, Any]:
    """The commands on a log with a mistake; `right` is what they print about the right log, by command."""
    scene = mistake.scene()
    with TemporaryDirectory() as folder:
        figures = _walk(mistake, scene, mistake.make(scene.columns), Path(folder))
    texts = figures.pop("texts")
    named = [
        step
        for step, text in texts.items()
        if names_cure(text, mistake.says) and not names_cure(right.get(step, ""), mistake.says)
    ]
    judged = [
        Statement(mistake.name, text, probability, names_cure(text, mistake.says))._asdict()
        for text, probability in figures.pop("claims")
    ]
    last = mistake.steps[-1][0]
    fitted = last in ("identify", "gap") and figures["codes"].get(last) == 0
    return figures | {
        "mistake": mistake.name,
        "named_by": named,
        "named": bool(named),
        "physics_blamed": fitted and not named,
        "statements": figures["statements"] + judged,
        "said": {step: text[-KEPT:] for step, text in texts.items()},
    }


def _walk(mistake: Mistake, scene: Scene, columns: Columns, folder: Path) -> dict[str, Any]:
    """Texts and exit codes by command, statements of init, claims of the check, Next, and CPU times."""
    paths = _written(mistake, scene, columns, folder)
    texts, codes, seconds = dict[str, str](), dict[str, int](), dict[str, float]()
    claims = dict[str, Claim]()
    for words in mistake.steps:
        options = mistake.options if words[0] == "import" else ()
        if words[0] == "import" and scene.effort and "--effort" not in words:
            options = (*options, "--effort", scene.effort)
        done = run(*(word.format(**paths) for word in words), *options)
        command = words[0]
        if command != "init":  # whose statements are in its JSON
            claims |= {claim.text: claim for claim in claims_in(done.err)}
        texts[command] = f"{texts.get(command, '')} {done.text}".strip()
        codes[command] = codes.get(command, 0) or done.code
        seconds[command] = seconds.get(command, 0.0) + done.seconds
        if done.code:  # later commands need what this one would have written
            if command != "init":
                break
    proposal = proposal_of(folder / "init/init.json")
    statements, following = list[dict[str, Any]](), None
    if proposal is not None:
        known = altered(scene.known, scene.columns, columns)
        if mistake.robot in BUILT_IN:  # another arm, of whose drives the log tells nothing
            known = replace(known, gain=None, effort="", columns={"time": ["t"]})
        statements = [one._asdict() for one in of_init(mistake.name, proposal, known)]
        following = run_next(proposal, folder / "next") if len(mistake.steps) > 1 else None
    return {
        "texts": texts,
        "codes": codes,
        "seconds": seconds,
        "statements": statements,
        "next": following,
        "claims": list(claims.values()),
    }


def _written(mistake: Mistake, scene: Scene, columns: Columns, folder: Path) -> dict[str, Path | str]:
    """Write logs and robot files; returns the paths that stand for words in braces."""
    (folder / "init").mkdir()
    write_log(folder / "log.csv", columns)
    for name, make in mistake.others.items():
        write_log(folder / f"{name}.csv", make())
    stated = mistake.robot or scene.robot
    described = scene.arm
    if mistake.robot in BUILT_IN:
        described = urdf_text(read_model(mistake.robot))
    elif mistake.robot.startswith("<mujoco"):
        described = mistake.robot
    arm = folder / f"arm{'.xml' if described.startswith('<mujoco') else '.urdf'}"
    arm.write_text(described)
    robot: Path | str = arm
    if stated in BUILT_IN:
        robot = stated
    elif stated.startswith("format"):
        robot = folder / "stated.toml"
        robot.write_text(stated)
    return {"folder": folder, "log": folder / "log.csv", "arm": arm, "robot": robot}


def write_log(path: Path, columns: Columns) -> None:
    """Write a log as CSV."""
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, "%.9g", ",", header=",".join(columns), comments="")
