"""The question that is asked before a real arm moves, or may."""

import os
import sys

from exidyn.identify.text_table import paragraph

from ..run.errors import NotAllowed, NotConfirmed
from .run_summary import BEGIN_SLOWLY, NOT_RATED

UNATTENDED = "EXIDYN_UNATTENDED"
"""Environment variable that, by the value yes, lets arms move unconfirmed: for test stands."""


def require_attended(simulated: bool, yes: bool) -> None:
    """Raise where no one would be asked though something real moves.

    Raises:
        NotAllowed: --yes alone, which a script that is reused might have by oversight.
    """
    if yes and not simulated and os.environ.get(UNATTENDED) != "yes":
        raise NotAllowed(
            f"--yes moves a real arm unasked only where {UNATTENDED}=yes is in the environment. Leave it out "
            "to be asked"
        )


def confirm_reading(risk: str) -> None:
    """Return if reading the controller can do nothing to the arm, or it was confirmed.

    Args:
        risk: What it may do; empty for nothing.

    Raises:
        NotConfirmed: As `confirm`.
    """
    if risk:
        print("\n" + "\n".join(paragraph(risk)) + "\n", file=sys.stderr)
        _ask("Support the arm. Type yes to read it: ", "nothing was sent")


def confirm(simulated: bool, yes: bool, advice: str = BEGIN_SLOWLY) -> None:
    """Return if it was confirmed, or if nothing real moves.

    Args:
        simulated: Whether nothing real moves.
        yes: Whether --yes was given.
        advice: How to begin, behind "keep a hand on it".

    Raises:
        NotAllowed: As `require_attended`.
        NotConfirmed: Anything but "yes" was answered, or there is no terminal to answer.
    """
    require_attended(simulated, yes)
    if simulated:
        return
    print("\n" + "\n".join(paragraph(NOT_RATED + advice)) + "\n", file=sys.stderr)
    if yes:
        return
    _ask("Type yes to move the arm: ", "nothing was moved")


def _ask(question: str, nothing: str) -> None:
    """Return if the answer is yes."""
    print(question, end="", file=sys.stderr, flush=True)
    try:
        answer = input()
    except EOFError:
        print(file=sys.stderr)
        raise NotConfirmed(f"there is no terminal to type yes in,  {nothing}. Run it in a terminal") from None
    if answer.strip() != "yes":
        raise NotConfirmed(f"not confirmed, {nothing}; it takes the word yes")
