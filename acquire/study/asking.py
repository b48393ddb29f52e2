"""What a person is told and asked to do between runs."""

import sys

from tqdm import tqdm

from ..arguments.command import complaint
from ..run.errors import NotConfirmed


def tell(words: object) -> None:
    """Print a sentence on standard error, above a bar that is there, in one line for scripts."""
    tqdm.write(complaint(f"exidyn: {' '.join(str(words).split())}"), sys.stderr)


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
