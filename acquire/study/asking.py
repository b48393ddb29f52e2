"""What a person is asked to do between runs."""

import sys

from ..run.errors import NotConfirmed


def ask(request: str) -> None:
    """Ask for something in one sentence, and wait until it is done.

    Raises:
        NotConfirmed: There is no terminal to answer in.
    """
    print(f"{request}, then press Enter: ", end="", file=sys.stderr, flush=True)
    try:
        input()
    except EOFError:
        print(file=sys.stderr)
        raise NotConfirmed(
            "there is no terminal to answer in, nothing was moved. The same command goes on from here"
        ) from None
