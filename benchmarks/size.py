"""Size of the package: its lines and functions, and how many of them a newcomer meets on the way.

Each way is walked in a process that notes which functions of the package are entered: from a CSV log to a
fit, from two runs to a page, and one cycle of the recording loop down to the driver. A second checkout is
printed beside the first: before and after.
"""

import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from common import parser, save, show
from parts.size.source import counts_of
from parts.size.walks import Walk, Walker

HERE = Path(__file__).resolve().parents[1]
WALKS: dict[str, Callable[[Walker], Walk]] = {
    "CSV log to fit": Walker.fit,
    "two runs to diagnosis": Walker.diagnosis,
    "fit and two runs to one page": Walker.page,
    "one cycle, mock": Walker.cycle_of_mock,
    "one cycle, UR's socket": Walker.cycle_of_ur,
}
QUICK = ("CSV log to fit",)


def walked(root: Path, names: tuple[str, ...]) -> dict[str, int]:
    """Functions, classes and files of each walk."""
    with tempfile.TemporaryDirectory() as folder:
        walker = Walker(root, Path(folder))
        return {
            f"{name}: {what}": count
            for name in names
            for what, count in WALKS[name](walker)._asdict().items()
        }


def main() -> None:
    given = parser(__doc__.splitlines()[0])
    given.add_argument(
        "roots", nargs="*", type=Path, metavar="ROOT", help="one checkout, or before and after"
    )
    chosen = given.parse_args()
    roots = chosen.roots or [HERE]
    names = [str(root) for root in roots]
    sizes = [counts_of(root) for root in roots]
    _beside("The package", names, sizes)
    walks = [walked(root, QUICK if chosen.quick else tuple(WALKS)) for root in roots]
    _beside("Entered on the way", names, walks)
    figures = zip(names, sizes, walks, strict=True)
    save(chosen.json, {name: {"source": size, "walks": walk} for name, size, walk in figures})


def _beside(title: str, names: list[str], figures: Sequence[Mapping[str, int]]) -> None:
    """A table with a column a checkout."""
    show(title, ["", *names], [[what, *(one[what] for one in figures)] for what in figures[0]])


if __name__ == "__main__":
    main()
