"""The question that is asked before a real arm moves."""

import os
import sys

from exidyn.identify.text_table import paragraph

from .run.errors import NotAllowed, NotConfirmed
from .run_summary import NOT_RATED

UNATTENDED = "EXIDYN_UNATTENDED"
"""Environment variable that says, by the value yes, that arms may move with nobody asked: for test stands."""


def require_attended(simulated: bool, yes: bool) -> None:
    """Raise where nobody would be asked though something real moves.

    Raises:
        NotAllowed: --yes alone, which a script that is reused might have without anybody thinking of it.
    """
    if yes and not simulated and os.environ.get(UNATTENDED) != "yes":
        raise NotAllowed(
            f"--yes moves a real arm unasked only where {UNATTENDED}=yes is in the environment. Leave it out "
            "to be asked"
        )


def confirm(simulated: bool, yes: bool) -> None:
    """Return if somebody said yes, or if nothing real moves.

    Args:
        simulated: Whether nothing real moves.
        yes: Whether --yes was given.

    Raises:
        NotAllowed: As `require_attended`.
        NotConfirmed: Anything but "yes" was answered, or nobody is there to answer.
    """
    require_attended(simulated, yes)
    if simulated:
        return
    print("\n" + "\n".join(paragraph(NOT_RATED)) + "\n", file=sys.stderr)
    if yes:
        return
    print("Type yes to move the arm: ", end="", file=sys.stderr, flush=True)
    try:
        answer = input()
    except EOFError:
        print(file=sys.stderr)
        raise NotConfirmed("nobody is there to type yes, nothing was moved. Run it in a terminal") from None
    if answer.strip() != "yes":
        raise NotConfirmed("not confirmed, nothing was moved; it takes the word yes")
