"""Options that several commands share, and checks that results can be written before any work is done."""

import errno
from argparse import ArgumentTypeError
from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np

from exidyn.identification.robot_files.description import NAMED
from exidyn.identification.robot_files.robot_file import builtin_names
from exidyn.trajectories.errors import BadLimits

from ..terminal.json_output import SCREEN
from .command import Option, any_number, not_negative, percent, positive

ROBOT_FILES = f"robot.toml, {NAMED}, or built in: {', '.join(builtin_names())}"


def _json_file(text: str) -> Path:
    """A path that can be written and ends in .json: `--json run.mcap` would overwrite a recording."""
    path = Path(text)
    if path != SCREEN and path.suffix != ".json":
        raise ArgumentTypeError(f"{text} must end in .json, or be - for standard output")
    if path != SCREEN:
        require_file(path, "--json")
    return path


PLAN = Option("plan TRAJECTORY", "trajectory file (.toml) of exidyn excite", Path)
SPEED = Option("--speed PERCENT", "percent of the planned speed; default: 100", percent, 1.0)
VALIDATE = Option("--validate RUN...", "validation runs, which are predicted and not fitted", Path, [])
AS_RECORDED = Option("--as-recorded", "do not check columns, units and signs of the recordings")
NO_COLLISION = Option("--no-collision", "do not check collisions of the arm with itself and obstacles")
CELL = Option("--cell FILE", "TOML with [[obstacle]] and [[region]] rows, see docs", Path)
CHECK = Option("--check", "first identify a simulated arm: what the motion will determine, and how well")
JSON = Option(
    "--json FILE",
    "also write the result as JSON (FILE.json), or with - print JSON instead of the text",
    _json_file,
)
FULL = Option("--full", "print all tables, not only the verdict and one table")
BODY = (
    Option("--mass KG", "mass of the payload", positive),
    Option("--com X Y Z", "its center of mass [m]", any_number),
    Option(
        "--inertia XX XY XZ YY YZ ZZ",
        "its inertia about the center of mass [kg m²]; without it, a point",
        any_number,
    ),
)
"""Options of the payload on the flange."""
FREE = Option("--free RUN...", "runs without contact that the fit has not used, for the threshold", Path, [])
ALARMS_PER_HOUR = Option("--alarms-per-hour N", "accepted false alarms of contact; default: 1", positive, 1.0)


def robot_option(why: str = "", required: bool = False) -> Option:
    """The option --robot."""
    return Option("--robot ROBOT", ": ".join(filter(None, (why, ROBOT_FILES))), required=required)


def output_option(value: str, default: Path | None = None, meaning: str = "") -> Option:
    """The option --output or -o, with a FILE or FOLDER."""
    return Option(f"--output -o {value}", meaning, Path, default)


def seed_option(meaning: str) -> Option:
    """The option --seed."""
    return Option("--seed N", meaning, not_negative, 0)


_BY_DATA = "default: from the data"
FILTERS = (
    Option("--position-cutoff HZ", f"low-pass of positions before differentiation; {_BY_DATA}", positive),
    Option("--torque-cutoff HZ", f"largest frequency at which torques are compared; {_BY_DATA}", positive),
    Option("--standstill RAD/S", f"speed below which a joint sticks; {_BY_DATA}", positive),
)
"""Options of the filter cutoffs and of the standstill speed."""


def view_options(shown: str) -> tuple[Option, ...]:
    """The options --view and --save of a command that shows something in Rerun's viewer."""
    return (
        Option("--view", f"show {shown} in Rerun's viewer"),
        Option("--save FILE", "save that view as a file (.rrd)", Path),
    )


def payload_name(text: str) -> str:
    """Name of a payload; empty for "none"."""
    return "" if text == "none" else text


def joint_values(values: Sequence[float] | None, joints: int, option: str) -> np.ndarray | None:
    """One value per joint, shape (n,); a single value applies to all joints.

    Raises:
        BadLimits: Their number is another; the message names the option.
    """
    if values is None:
        return None
    if len(values) not in (1, joints):
        raise BadLimits(f"{option}: {len(values)} values; give 1 or {joints}, one per joint")
    return np.broadcast_to(np.array(values), (joints,)).copy()


def require_file(path: Path | None, option: str, read: Iterable[Path | str | None] = ()) -> None:
    """Check that the result of an option can be written, before any work is done for it, and make its folder.

    An option that is absent, here or among the read files, is None.

    Raises:
        OSError: If it is a folder, is among the read files, or cannot be made; the message names the option.
    """
    if path is None:
        return
    require_apart(path, option, read)
    if path.parent.exists() and not path.parent.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, f"{option}: this is a file, not a folder", str(path.parent))
    _make_writable(path.parent, option, path)


def require_apart(path: Path, option: str, read: Iterable[Path | str | None]) -> None:
    """Raise `OSError` with the option if a result is a folder or would overwrite a file that is read."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, f"{option} needs a file, this is a folder", str(path))
    sources = [source for source in read if source and Path(source).exists()]
    if path.exists() and any(map(path.samefile, sources)):
        raise FileExistsError(
            errno.EEXIST, f"{option} would overwrite a file that is read; name another", str(path)
        )


def make_folder(folder: Path) -> None:
    """Make the folder of the results, before any work is done for them; `OSError` names the option."""
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(errno.EEXIST, "this file exists; --output needs a folder", str(folder))
    _make_writable(folder, "--output", folder)


def _make_writable(folder: Path, option: str, path: Path) -> None:
    """Make a folder in which a file can be written; an error names the path of the option."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OSError(error.errno, f"{option} cannot be written: {error.strerror}", str(path)) from error
