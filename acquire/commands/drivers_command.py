"""exidyn drivers: controllers and their settings; exidyn completion: completion scripts for shells."""

from argparse import ArgumentParser, Namespace
from typing import Any

from exidyn.drivers import driver_class, explain, known_drivers

from ..arguments.command import Command, Option
from . import COMMANDS, command

SHELLS = ("bash", "zsh", "fish", "powershell", "tcsh")
FILES = {"ARM", "FILE", "FIT", "REAL", "ROBOT", "RUN", "SIM", "SOURCE", "TRAJECTORY"}
"""Placeholders of values that can be files; FOLDER stands for a folder."""


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
            "instead print the file with which the controller finds this host, if it needs one "
            "(kuka_rsi: RSI_EthernetConfig.xml)",
            dest="address",
        ),
    ),
)
def drivers_command(args: Namespace) -> None:
    """List the drivers, or print a controller file to be filled in."""
    if args.name is None:
        drivers = known_drivers()
        width = max(map(len, drivers))
        print("\n".join(f"{name:<{width}}  {entry.purpose}" for name, entry in drivers.items()))
        return
    text = driver_class(args.name).controller_file(args.address) if args.address else explain(args.name)
    print(text, end="")


@Command(
    "Print the script with which a shell completes exidyn's command lines.",
    (
        "exidyn completion bash > ~/.local/share/bash-completion/completions/exidyn",
        "exidyn completion zsh > ~/.zfunc/_exidyn",
        "exidyn completion fish > ~/.config/fish/completions/exidyn.fish",
    ),
    (Option("shell SHELL", ", ".join(SHELLS), SHELLS),),
    """bash: the package bash-completion finds the file there; without it, or for one
      terminal:
      eval "$(exidyn completion bash)"
zsh:  ~/.zshrc needs fpath+=~/.zfunc before compinit
The script is self-contained: exidyn does not run when Tab is pressed.
Print it again after an update.""",
)
def completion_command(args: Namespace) -> None:
    """Print the completion script of a shell."""
    import shtab  # importing the parsers of all commands takes a second or two

    print(shtab.complete(parser_of_all(), args.shell))


def parser_of_all() -> ArgumentParser:
    """One parser with all commands and options, for completion; `exidyn` itself imports only one command."""
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
    """Tell shtab the values of an option."""
    import shtab

    if action.metavar == "DRIVER":
        action.choices = tuple(known_drivers())
    elif action.metavar == "FOLDER":
        action.complete = shtab.DIRECTORY
    elif action.metavar in FILES and action.choices is None:
        action.complete = shtab.FILE
