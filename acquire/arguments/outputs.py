"""Where results go: --output and --json, looked at before any work is done for them."""

import argparse
import errno
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryFile

from ..terminal.json_output import SCREEN


def add_output(
    parser: argparse.ArgumentParser,
    metavar: str,
    default: Path | None = None,
    meaning: str = "default: %(default)s",
) -> None:
    """Add --output and -o; `metavar` is FILE or FOLDER, `meaning` the help."""
    parser.add_argument("--output", "-o", type=Path, default=default, metavar=metavar, help=meaning)


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add --json."""
    parser.add_argument(
        "--json",
        type=_json_file,
        metavar="FILE",
        help="write the result as JSON too (FILE.json), or with - print it in place of the text",
    )


def _json_file(text: str) -> Path:
    """A path that ends in .json, so that `--json run.mcap` does not write over a recording."""
    path = Path(text)
    if path != SCREEN and path.suffix != ".json":
        raise argparse.ArgumentTypeError(f"{text} must end in .json, or be - for standard output")
    return path


def require_json(path: Path | None) -> None:
    """Make sure that the JSON can be written before any work is done for it.

    Raises:
        OSError: It cannot; names the option.
    """
    if path is not None and path != SCREEN:
        require_file(path, "--json")


def require_file(path: Path, option: str, read: Iterable[Path | str] = ()) -> None:
    """Make sure that a result can be written before any work is done for it; makes its folder.

    Args:
        path: Of the result.
        option: That names it.
        read: What the result is made of, and must not be written over.

    Raises:
        OSError: It is a folder, one of those read, or cannot be made; names the option.
    """
    require_apart(path, option, read)
    if path.parent.exists() and not path.parent.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, f"{option}: this is a file, no folder", str(path.parent))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise OSError(error.errno, f"{option} cannot be written: {error.strerror}", str(path)) from error


def require_apart(path: Path, option: str, read: Iterable[Path | str]) -> None:
    """Make sure that a result is no folder, and not written over what it is made of.

    Raises:
        OSError: It is; names the option.
    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, f"{option} needs a file, this is a folder", str(path))
    if path.exists() and any(Path(one).exists() and path.samefile(one) for one in read):
        raise FileExistsError(
            errno.EEXIST, f"{option} would write over what is read; name another", str(path)
        )


def make_folder(folder: Path) -> None:
    """Make the folder for the results before any work is done for them.

    Raises:
        OSError: It cannot be made or written; names the option.
    """
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(errno.EEXIST, "this file exists; --output needs a folder", str(folder))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OSError(error.errno, f"--output cannot be written: {error.strerror}", str(folder)) from error
