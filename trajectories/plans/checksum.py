"""A line in a trajectory file by which a change of any other is noticed.

A digit that a disk, a copy or an editor changed leaves a motion that is just as well formed, and another one.
"""

import hashlib
import re

from ..errors import NotATrajectory

LINE = re.compile(r'^checksum = "([^"\n]*)"\r?\n', re.MULTILINE)


def sealed(text: str) -> str:
    """The text with its checksum in the second line."""
    first, rest = text.split("\n", 1)
    return f'{first}\nchecksum = "{_checksum(text)}"\n{rest}'


def require_unchanged(text: str) -> None:
    """Compare a text with its checksum; one without was written by hand and passes.

    Raises:
        NotATrajectory: It is another text than was sealed.
    """
    found = LINE.search(text)
    if found and found[1] != _checksum(text[: found.start()] + text[found.end() :]):
        raise NotATrajectory(
            f"the file has changed since exidyn wrote it: its checksum is not {found[1]} any more. Plan the "
            "motion again, or, if the change is meant, remove the line that begins with 'checksum'"
        )


def _checksum(text: str) -> str:
    """Of the lines, however they end."""
    return hashlib.sha256("\n".join(text.splitlines()).encode()).hexdigest()[:16]
