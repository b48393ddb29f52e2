"""--json: what a command found, for scripts."""

import argparse
import errno
import json
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np

SCREEN = Path("-")
"""In place of a file: standard output."""


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


def hand_over(page: str, text: str, path: Path | None) -> None:
    """Print the page, or the JSON text where that goes to standard output; write it where it has a file."""
    print(text.rstrip("\n") if path == SCREEN else page, flush=True)
    if path is not None and path != SCREEN:
        write_whole(path, text)
        print(f"written: {path}", file=sys.stderr)


def write_whole(path: Path, text: str) -> None:
    """Write a file that appears under its name only when it is whole."""
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)


def json_text(table: dict[str, Any]) -> str:
    """JSON with a key a line."""
    return json.dumps(table, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """Arrays as nested lists; what is no number, which JSON does not have, is None."""
    if isinstance(value, dict):
        return {name: plain(one) for name, one in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value
