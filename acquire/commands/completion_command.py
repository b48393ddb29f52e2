"""exidyn completion: what makes a shell complete commands, options and file names at Tab."""

import argparse
from collections.abc import Sequence
from typing import Any

from ..arguments.common import command_parser
from . import COMMANDS, command_module

SHELLS = ("bash", "zsh", "fish", "powershell", "tcsh")
EXAMPLES = (
    "exidyn completion bash > ~/.local/share/bash-completion/completions/exidyn",
    "exidyn completion zsh > ~/.zfunc/_exidyn",
    "exidyn completion fish > ~/.config/fish/completions/exidyn.fish",
)
NOTES = """bash: the package bash-completion finds the file there by itself; without it, or
      for one terminal:
      eval "$(exidyn completion bash)"
zsh:  ~/.zshrc has fpath+=~/.zfunc before compinit
What is printed is complete: nothing of exidyn runs when Tab is pressed.
Print it anew after an update."""
FILES = {"ARM", "FILE", "FIT", "REAL", "ROBOT", "RUN", "SIM", "SOURCE", "TRAJECTORY"}
"""Metavars of what can be a file; FOLDER is a folder."""


def main(arguments: Sequence[str]) -> int:
    """Print the script of a shell."""
    given = parser().parse_args(arguments)
    import shtab  # the parsers of all commands, which it walks through, take a second or two to import

    print(shtab.complete(whole_parser(), given.shell))
    return 0


def parser() -> argparse.ArgumentParser:
    """What `exidyn completion` takes."""
    found = command_parser(
        "completion", "Print what makes a shell complete exidyn's command lines.", EXAMPLES, NOTES
    )
    found.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))
    return found


def whole_parser() -> argparse.ArgumentParser:
    """One parser of all commands with all their options; `exidyn` itself imports one command only."""
    top = argparse.ArgumentParser(prog="exidyn")
    top.add_argument("--version", action="store_true", help="print the version")
    commands = top.add_subparsers(dest="command", metavar="COMMAND")
    for name, purpose in COMMANDS.items():
        own = command_module(name).parser()
        for action in own._actions:
            _complete(action)
        commands.add_parser(name, parents=[own], help=purpose, description=purpose, add_help=False)
    return top


def _complete(action: Any) -> None:
    """Name the values of an option, as shtab asks for it."""
    import shtab

    from exidyn.drivers import known_drivers

    if action.choices is not None:
        action.choices = tuple(action.choices)  # shtab takes tables for subcommands
    elif action.metavar == "DRIVER":
        action.choices = tuple(known_drivers())
    elif action.metavar == "FOLDER":
        action.complete = shtab.DIRECTORY
    elif action.metavar in FILES:
        action.complete = shtab.FILE
