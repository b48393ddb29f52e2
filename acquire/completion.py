"""Completion: the scripts with which shells complete exidyn's command lines."""

from argparse import Action, ArgumentParser
from typing import Any

from .arguments.command import Option
from .commands import COMMANDS, command

SHELLS = ("bash", "zsh", "fish", "powershell", "tcsh")
FILES = {"ARM", "FILE", "FIT", "ROBOT", "RUN", "SOURCE", "TRAJECTORY"}
"""Placeholders of values that can be files; FOLDER stands for a folder."""


class PrintScript(Action):
    """Prints the script of a shell, and ends."""

    def __call__(
        self, parser: ArgumentParser, namespace: Any, values: Any, option_string: Any = None
    ) -> None:
        """Print it; importing the parsers of all commands takes a second or two."""
        import shtab

        print(shtab.complete(parser_of_all(), values))
        parser.exit()


COMPLETION = Option(
    "--completion SHELL",
    f"print the script of Tab completion for {', '.join(SHELLS)}",
    SHELLS,
    action=PrintScript,
)


def parser_of_all() -> ArgumentParser:
    """One parser with all commands and options; `exidyn` itself imports only one command."""
    top = ArgumentParser(prog="exidyn")
    top.add_argument("--version", action="store_true", help="print the version")
    COMPLETION.add_to(top)
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

    from exidyn.drivers import known_drivers

    if action.metavar == "DRIVER":
        action.choices = tuple(known_drivers())
    elif action.metavar == "FOLDER":
        action.complete = shtab.DIRECTORY
    elif action.metavar in FILES and action.choices is None:
        action.complete = shtab.FILE
