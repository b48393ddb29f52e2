"""Options that several commands have, and where results go, looked at before any work is done for them."""

import errno
from argparse import ArgumentTypeError
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryFile

from exidyn.identification.robot_files.description import NAMED
from exidyn.identification.robot_files.robot_file import builtin_names

from ..terminal.json_output import SCREEN
from .command import Option, any_number, percent, positive, whole

FLEET = Path("exidyn-fleet")
"""Where results of a fleet are kept unless a person says otherwise."""
ROBOT_FILES = f"robot.toml, {NAMED}, or built in: {', '.join(builtin_names())}"


def _json_file(text: str) -> Path:
    """A path that ends in .json, so that `--json run.mcap` does not write over a recording."""
    path = Path(text)
    if path != SCREEN and path.suffix != ".json":
        raise ArgumentTypeError(f"{text} must end in .json, or be - for standard output")
    return path


PLAN = Option("plan TRAJECTORY", "trajectory file (.toml) of exidyn excite", Path)
NAME = Option("--name NAME", "what to call the run; default: the name of the file")
SPEED = Option("--speed PERCENT", "of the planned one; default: 100", percent, 1.0)
VALIDATE = Option("--validate RUN...", "runs that are only predicted", Path, [])
AS_RECORDED = Option("--as-recorded", "take columns, units and signs as they are stated, without a check")
NO_COLLISION = Option("--no-collision", "do not look at the arm's geometry and at obstacles")
CELL = Option("--region --cell FILE", "TOML with [[obstacle]] and [[region]] rows, see docs", Path)
PACKAGES = Option("--packages FOLDER...", "where meshes are", Path, [], repeated=True)
JSON = Option(
    "--json FILE",
    "write the result as JSON too (FILE.json), or with - print it in place of the text",
    _json_file,
)
BODY = (
    Option("--mass KG", "mass of the body on it", positive),
    Option("--com X Y Z", "its centre of mass [m]", any_number),
    Option("--inertia XX XY XZ YY YZ ZZ", "and about that [kg m^2]", any_number),
)
"""The one body on the flange."""
ALARMS = Option(
    "--alarms-per-arm-year N",
    "false alarms to accept, over all parameters of an arm; 0.1 is one in ten years",
    positive,
    0.1,
)


def robot_option(why: str = "", required: bool = False) -> Option:
    """--robot."""
    return Option("--robot ROBOT", ": ".join(filter(None, (why, ROBOT_FILES))), required=required)


def output_option(value: str, default: Path | None = None, meaning: str = "") -> Option:
    """--output and -o, of a FILE or FOLDER."""
    return Option(f"--output -o {value}", meaning, Path, default)


def seed_option(meaning: str) -> Option:
    """--seed."""
    return Option("--seed N", meaning, whole, 0)


def filters(torque_default: str = "from the data") -> tuple[Option, ...]:
    """The cut-offs and the speed of standstill; `torque_default` in words, as the help has it."""
    smoothing, usual = "low-pass of positions before differentiation", "default: from the data"
    return (
        Option("--position-cutoff HZ", f"{smoothing}; {usual}", positive),
        Option("--torque-cutoff HZ", f"up to where torque is compared; default: {torque_default}", positive),
        Option("--standstill RAD/S", f"speed below which a joint sticks; {usual}", positive),
    )


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
        path: Where the result is written.
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
