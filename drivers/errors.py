"""Errors of drivers; each message states a fact with its value, the limit, and what to try."""

import difflib
from collections.abc import Iterable

LONGEST = 290
"""Maximum length of a message [characters]: with the name of the command, at most 300 are printed."""
HEAD = 200
"""Characters kept from the beginning of a longer message; its end, which says what to try, is kept too."""
LISTED = 150
"""Maximum length of a list of valid names [characters], which leaves room for the rest of the message."""


class DriverError(Exception):
    """Base of all errors of drivers; the text, one line of bounded length, is meant for the user."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*(_shorten(a) if isinstance(a, str) else a for a in arguments))


def _shorten(text: str) -> str:
    """One printable line of bounded length, as in `identification.errors`, which drivers do not import."""
    line = " ".join(text.split())
    line = "".join(character if character.isprintable() else repr(character)[1:-1] for character in line)
    return line if len(line) <= LONGEST else f"{line[:HEAD]} ... {line[HEAD + 5 - LONGEST :]}"


def listed(names: Iterable[str], like: str) -> str:
    """Names separated by commas; of too many, those most similar to `like`, and the number of the others."""
    valid = list(names)
    if len(", ".join(valid)) <= LISTED:
        return ", ".join(valid)
    shown = difflib.get_close_matches(like, valid, n=len(valid), cutoff=0.0)
    while len(", ".join(shown)) > LISTED:
        shown.pop()
    return f"{', '.join(shown)} and {len(valid) - len(shown)} more"


class UnknownDriver(DriverError, LookupError):
    """A name that is not in the table; the message lists the valid ones."""

    def __init__(self, name: str, valid: Iterable[str]) -> None:
        super().__init__(f"unknown driver '{name}'. Valid: {', '.join(valid)}")


class BadDriver(DriverError):
    """A driver of an installed package that cannot be used; the message names the package."""

    def __init__(self, driver: str, package: str, why: str) -> None:
        super().__init__(f"driver '{driver}' of the package {package}: {why}")


class MissingPackage(DriverError, ImportError):
    """A package that only some drivers need is not installed; the message names the extra to install."""

    def __init__(self, driver: str, package: str | None, extra: str) -> None:
        super().__init__(
            f"driver {driver} needs the package {package}, which is not installed. "
            f'In the folder of exidyn: pip install ".[{extra}]"'
        )


class BadSettings(DriverError, ValueError):
    """Settings that are missing, unknown or out of range, or that the bus cannot carry."""


class NotReady(DriverError):
    """The controller answers but refuses to begin."""


class LinkLost(DriverError):
    """Nothing comes back from the controller, or nothing readable."""


class Unreadable(DriverError, ValueError):
    """A telegram or a sample with an impossible value."""
