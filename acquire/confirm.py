"""The question that is asked before a real arm moves."""

import os
import sys

from .run.errors import NotAllowed, NotConfirmed
from .run_summary import NOT_RATED

UNATTENDED = "EXIDYN_UNATTENDED"
"""Environment variable that says, by the value yes, that arms may move with nobody asked: for test stands."""


def confirm(simulated: bool, yes: bool) -> None:
    """Return if somebody said yes, or if nothing real moves.

    Args:
        simulated: Whether nothing real moves.
        yes: Whether --yes was given.

    Raises:
        NotAllowed: --yes alone, which a script that is reused might have without anybody thinking of it.
        NotConfirmed: Anything but "yes" was answered, or nobody is there to answer.
    """
    if simulated:
        return
    print(f"\n{NOT_RATED}\n", file=sys.stderr)
    if yes:
        if os.environ.get(UNATTENDED) != "yes":
            raise NotAllowed(
                f"--yes moves a real arm unasked only where {UNATTENDED}=yes is in the environment"
            )
        return
    print("Type yes to move the arm: ", end="", file=sys.stderr, flush=True)
    try:
        answer = input()
    except EOFError:
        answer = ""
    if answer.strip() != "yes":
        raise NotConfirmed("not confirmed, nothing was moved; it takes the word yes")
