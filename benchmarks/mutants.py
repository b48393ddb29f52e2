"""Mutants: faults put into the diagnosis one at a time, and which test notices each.

A copy of the package is changed in one place, and the tests of the diagnosis run on it until one fails. A
fault that no test notices could come in unseen. Without a fault all tests have to pass.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from common import imports_as_here, options, save, show

ROOT = Path(__file__).resolve().parents[1]
TESTS = "tests/identify/diagnosis"
KEPT = ("exidyn", "identify", "acquire", "drivers", "trajectories", "tests", "benchmarks", "pyproject.toml")
"""Of the repository, what a copy has; a test that compares two of its folders needs both."""


class Mutant(NamedTuple):
    """A fault: in this file of the diagnosis, this text becomes that one."""

    name: str
    file: str
    text: str
    becomes: str


MUTANTS = (
    Mutant(
        "Occam factor of shapes halved",
        "search/ranking.py",
        "- np.log(len(group))",
        "- 0.5 * np.log(len(group))",
    ),
    Mutant(
        "sign of one-sidedness",
        "questions/question.py",
        "- np.log(2.0) * signs",
        "+ np.log(2.0) * signs",
    ),
    Mutant("tilt axes swapped", "candidates/base_tilt.py", "run, (0, 1))", "run, (1, 0))"),
    Mutant(
        "sign of the clock",
        "runs/rows.py",
        "names, -np.concatenate([rate",
        "names, np.concatenate([rate",
    ),
    Mutant(
        "runs held out exclude nothing",
        "search/selected.py",
        "return answer.held_out <",
        "return 0.0 * answer.held_out <",
    ),
    Mutant(
        "Student's tail without its degrees of freedom",
        "blocks/block_likelihood.py",
        "tail = 0.5 * (rows + FREEDOM) *",
        "tail = 0.5 * rows *",
    ),
    Mutant(
        "amplitude with as many degrees of freedom as blocks",
        "blocks/block_likelihood.py",
        "freedom = len(shares.own) - 1.0",
        "freedom = len(shares.own) + 0.0",
    ),
    Mutant(
        "weights ignore that rows are alike",
        "blocks/prediction.py",
        "return self.independent * self.trust / self.variance",
        "return self.trust / self.variance",
    ),
    Mutant(
        "sensors' linearity not squared", "blocks/prediction.py", "wrong = LINEAR**2 *", "wrong = LINEAR *"
    ),
    Mutant(
        "one joint shows what acts everywhere",
        "search/selected.py",
        "np.median(answer.by_joint)",
        "np.max(answer.by_joint)",
    ),
    Mutant(
        "a term that was left out is as likely as any other",
        "candidates/parts.py",
        "FORGOTTEN = 5.0",
        "FORGOTTEN = 1.0",
    ),
    Mutant("four times the noise is nothing", "results/remainder.py", "BEYOND = 2.0", "BEYOND = 4.0"),
    Mutant(
        "what is immaterial is chosen",
        "search/search.py",
        "[rival for rival in best if _material(rival, prediction)]",
        "list(best)",
    ),
    Mutant("what went out is taken again", "search/search.py", "out |= gone  # in", "out.copy()  # in"),
    Mutant(
        "a name beside as much without one",
        "search/selected.py",
        "if self.unnamed >= 1.0 else",
        "if self.unnamed >= 1e9 else",
    ),
    Mutant(
        "runs held out are fitted too",
        "search/problem.py",
        "Blocks.of(runs, HELD_OUT)",
        'Blocks.of(runs, "nothing")',
    ),
)


def first_failure(mutant: Mutant, folder: Path) -> str:
    """The test that fails first on a copy with the fault; empty if none does.

    Raises:
        ValueError: The file has not the text, or has it more than once.
    """
    file = folder / "identify" / "diagnosis" / mutant.file
    before = file.read_text()
    if before.count(mutant.text) != 1:
        raise ValueError(
            f"{mutant.name}: {mutant.file} has {before.count(mutant.text)} x {mutant.text!r}; 1 is needed"
        )
    file.write_text(before.replace(mutant.text, mutant.becomes))
    failed = failing(folder)
    file.write_text(before)
    return failed


def failing(folder: Path) -> str:
    """The test that fails first on a copy; empty if none does."""
    command = [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider", "-m", "not clocked", TESTS]
    ran = subprocess.run(
        command, cwd=folder, env=_environment(folder), capture_output=True, text=True, check=False
    )
    failed = [line for line in ran.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].split(" - ")[0].split("/")[-1] if failed else ""


def _environment(folder: Path) -> dict[str, str]:
    return imports_as_here() | {"PYTHONPATH": str(folder)}


def copied(folder: Path) -> Path:
    """What the tests need, copied into a folder."""
    for name in KEPT:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(
                source, folder / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__")
            )
        else:
            shutil.copy(source, folder / name)
    return folder


def main() -> None:
    chosen = options(__doc__.splitlines()[0])
    with tempfile.TemporaryDirectory() as name:
        folder = copied(Path(name))
        mutants = MUTANTS[1:2] if chosen.quick else MUTANTS
        if not chosen.quick and (failed := failing(folder)):
            raise SystemExit(f"without any fault {failed} fails: run ./check first")
        noticed = {one.name: first_failure(one, folder) for one in mutants}
    show("Faults in the diagnosis, and the first test that fails", ["fault", "test"], list(noticed.items()))
    survived = [name for name, test in noticed.items() if not test]
    print(f"  survived: {len(survived)} of {len(noticed)}" + "".join(f"\n    {name}" for name in survived))
    save(chosen.json, {"mutants": len(noticed), "survived": len(survived), "noticed_by": noticed})


if __name__ == "__main__":
    main()
