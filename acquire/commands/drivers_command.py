"""exidyn drivers: controllers, and the settings of each; exidyn completion: scripts for shells."""

from argparse import ArgumentParser, Namespace
from typing import Any

from exidyn.drivers import driver_class, explain, known_drivers

from ..arguments.command import Command, Option
from . import COMMANDS, command

SHELLS = ("bash", "zsh", "fish", "powershell", "tcsh")
FILES = {"ARM", "FILE", "FIT", "REAL", "ROBOT", "RUN", "SIM", "SOURCE", "TRAJECTORY"}
"""Metavars of what can be a file; FOLDER is a folder."""


@Command(
    "List the drivers, or print the settings of one as a controller file for exidyn record.",
    (
        "exidyn drivers",
        "exidyn drivers can_mit > cell.toml",
        "exidyn drivers kuka_rsi --for-host 172.31.1.10 > RSI_EthernetConfig.xml",
    ),
    (
        Option("name [DRIVER]", ", ".join(known_drivers())),
        Option(
            "--for-host ADDRESS",
            "print instead the file that the controller itself needs to find this host, if it needs one "
            "(kuka_rsi: RSI_EthernetConfig.xml)",
            dest="address",
        ),
    ),
)
def drivers_command(given: Namespace) -> None:
    """List the drivers, or print a controller file of one to be filled in."""
    if given.name is None:
        drivers = known_drivers()
        width = max(map(len, drivers))
        print("\n".join(f"{name:<{width}}  {entry.purpose}" for name, entry in drivers.items()))
        return
    text = driver_class(given.name).controller_file(given.address) if given.address else explain(given.name)
    print(text, end="")


@Command(
    "Print what makes a shell complete exidyn's command lines.",
    (
        "exidyn completion bash > ~/.local/share/bash-completion/completions/exidyn",
        "exidyn completion zsh > ~/.zfunc/_exidyn",
        "exidyn completion fish > ~/.config/fish/completions/exidyn.fish",
    ),
    (Option("shell SHELL", ", ".join(SHELLS), SHELLS),),
    """bash: the package bash-completion finds the file there by itself; without it, or
      for one terminal:
      eval "$(exidyn completion bash)"
zsh:  ~/.zshrc has fpath+=~/.zfunc before compinit
What is printed is complete: nothing of exidyn runs when Tab is pressed.
Print it anew after an update.""",
)
def completion_command(given: Namespace) -> None:
    """Print the script of a shell."""
    import shtab  # the parsers of all commands, which it walks through, take a second or two to import

    print(shtab.complete(parser_of_all(), given.shell))


def parser_of_all() -> ArgumentParser:
    """One parser of all commands with all their options; `exidyn` itself imports one command only."""
    top = ArgumentParser(prog="exidyn")
    top.add_argument("--version", action="store_true", help="print the version")
    commands = top.add_subparsers(dest="command", metavar="COMMAND")
    for name, purpose in COMMANDS.items():
        parser = command(name).parser()
        for action in parser._actions:
            _complete(action)
        commands.add_parser(name, parents=[parser], help=purpose, description=purpose, add_help=False)
    return top


def _complete(action: Any) -> None:
    """Name the values of an option, as shtab asks for it."""
    import shtab

    if action.metavar == "DRIVER":
        action.choices = tuple(known_drivers())
    elif action.metavar == "FOLDER":
        action.complete = shtab.DIRECTORY
    elif action.metavar in FILES and action.choices is None:
        action.complete = shtab.FILE
