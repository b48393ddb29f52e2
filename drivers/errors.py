"""The errors of drivers, each a fact with a value, a limit and what to try.

DriverError
├── UnknownDriver     a name that is not in the table
├── BadDriver         a driver of an installed package that cannot be used
├── MissingPackage    a package that only some drivers need is not installed
├── BadSettings       settings that are missing, unknown or out of range, or a bus that cannot carry them
├── NotReady          the controller is there and refuses to begin
├── LinkLost          nothing comes back, or nothing that can be read
└── Unreadable        a telegram with a value that it cannot have
"""

import difflib
from collections.abc import Iterable

LONGEST = 290
"""Characters of a message: with the command's name before it, at most 300 are printed."""
HEAD = 200
"""Of those, how many are the beginning of a message that was longer; what to try stands at its end."""
LISTED = 150
"""Characters of a list of valid names, so that there is room for what is wrong."""


class DriverError(Exception):
    """Base of every error a driver raises; its text, one line of bounded length, is meant for the user."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*(_shortened(one) if isinstance(one, str) else one for one in arguments))


def _shortened(text: str) -> str:
    """The same as `exidyn.identification.errors.shortened`: drivers import nothing from that package."""
    line = " ".join(text.split())
    line = "".join(one if one.isprintable() else repr(one)[1:-1] for one in line)
    return line if len(line) <= LONGEST else f"{line[:HEAD]} ... {line[HEAD + 5 - LONGEST :]}"


def listed(names: Iterable[str], like: str) -> str:
    """Names with commas; if they are too many, those most like a given one, and how many more there are."""
    every = list(names)
    if len(", ".join(every)) <= LISTED:
        return ", ".join(every)
    shown = difflib.get_close_matches(like, every, n=len(every), cutoff=0.0)
    while len(", ".join(shown)) > LISTED:
        shown.pop()
    return f"{', '.join(shown)} and {len(every) - len(shown)} more"


class UnknownDriver(DriverError, LookupError):
    """A name that is not in the table; the message lists the valid ones."""

    def __init__(self, name: str, valid: Iterable[str]) -> None:
        super().__init__(f"unknown driver '{name}'. Valid: {', '.join(valid)}")


class BadDriver(DriverError):
    """A driver of an installed package that cannot be used; names the package."""

    def __init__(self, driver: str, package: str, why: str) -> None:
        super().__init__(f"driver '{driver}' of the package {package}: {why}")


class MissingPackage(DriverError, ImportError):
    """A package that only some drivers need is not installed; names the extra that brings it."""

    def __init__(self, driver: str, package: str | None, extra: str) -> None:
        super().__init__(
            f"driver {driver} needs the package {package}, which is not installed. "
            f'In the folder of exidyn: pip install ".[{extra}]"'
        )


class BadSettings(DriverError, ValueError):
    """Settings that are missing, unknown or out of range, or that the bus cannot carry."""


class NotReady(DriverError):
    """The controller is there and refuses to begin."""


class LinkLost(DriverError):
    """Nothing comes back from the controller, or nothing that can be read."""


class Unreadable(DriverError, ValueError):
    """A telegram, or a sample, with a value that it cannot have."""
