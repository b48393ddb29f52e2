"""Help, examples, completion and exit codes: what holds of every command."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from exidyn.acquire.arguments.parser import MEANINGS, READER_LEFT
from exidyn.acquire.command_line import COMMANDS, SHELLS, main, parser_of_all
from exidyn.acquire.commands import command

from ...parts.system_needs import BASH

pytestmark = pytest.mark.clocked(patient=True)

ROOT = Path(__file__).parents[3]


def examples(name: str) -> list[str]:
    """The command lines at the end of a help text."""
    epilog = command(name).parser().epilog
    return [line.strip() for line in epilog.rpartition("examples:\n")[2].splitlines()]


@pytest.mark.parametrize("name", COMMANDS)
def test_help_ends_with_examples_that_the_command_understands(name, capsys):
    with pytest.raises(SystemExit) as ended:
        main([name, "--help"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.rstrip().splitlines()[-1].strip() == examples(name)[-1]
    assert 1 <= len(examples(name)) <= 4
    for line in examples(name):
        words = shlex.split(line.partition(">")[0], comments=True)
        assert words[:2] == ["exidyn", name]
        command(name).parser().parse_args(words[2:])


@pytest.mark.parametrize("name", COMMANDS)
def test_what_is_the_same_is_called_the_same(name):
    found = command(name).parser()
    actions = {option: action for action in found._actions for option in action.option_strings}
    metavars = {"--robot": {"ROBOT", "FILE"}, "--output": {"FILE", "FOLDER"}, "--json": {"FILE"}}
    metavars |= {"--mass": {"KG"}, "--seed": {"N"}, "--save": {"FILE"}, "--speed": {"PERCENT"}}
    metavars |= {"--tick": {"S"}, "--length": {"S"}}
    for option in metavars.keys() & actions.keys():
        assert actions[option].metavar in metavars[option]
    assert ("--output" in actions) == ("-o" in actions)
    assert all(action.help for action in found._actions)


def test_exit_codes_are_where_people_look(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    text, page = capsys.readouterr().out, (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")
    for code, words in MEANINGS.items():
        assert f" {code} {words} " in " ".join(text.split())
        assert f"| {code} | {words} |" in page


def test_a_reader_that_leaves_is_no_complaint():
    """As `exidyn --help | head -1` where head has gone."""
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "exidyn.acquire.command_line", "init", "--driver"]
    silent = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, env=silent, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (READER_LEFT, b"")


def test_complaints_are_one_line(capsys):
    for arguments in (["identify"], ["record", "x.toml"], ["export", "x", "--to", "y"], ["nothing"]):
        with pytest.raises(SystemExit) as ended:
            main(arguments)
        assert ended.value.code == 2
        assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        ("identfy run.mcap", "Did you mean identify? 'exidyn --help' explains"),
        ("identify run.mcap --shape-fit x", "Did you mean --shapes? 'exidyn identify --help' explains"),
        (
            "identify run.mcap --as-recordd",
            "unrecognized arguments: --as-recordd. Did you mean --as-recorded? ",
        ),
        ("identify run.mcap --estimator weigthed", "invalid choice: 'weigthed' (choose from 'weighted', "),
        ("identify run.mcap --estimator weigthed", "Did you mean weighted? 'exidyn identify --help'"),
        ("idenitfy run.mcap", "Did you mean identify? 'exidyn --help' explains"),
        ("diagnose --vallidate", "unrecognized arguments: --vallidate. Did you mean --validate? "),
        ("diagnose a b --vallidate c", "--vallidate c. Did you mean --validate? 'exidyn diagnose"),
        ("identify --vallidate=run.mcap", "Did you mean --validate? 'exidyn identify --help'"),
        ("excite kr270 --kind sweep", "Did you mean sweeps?"),
        ("--completion zhs", "Did you mean zsh?"),
        ("identify run.mcap --xyz", "unrecognized arguments: --xyz. 'exidyn identify --help' explains"),
    ],
)
def test_of_what_is_mistyped_the_nearest_is_named(typed, words, capsys):
    with pytest.raises(SystemExit) as ended:
        main(typed.split())
    assert ended.value.code == 2
    [line] = capsys.readouterr().err.splitlines()
    assert words in line


@pytest.mark.parametrize("shell", SHELLS)
def test_completion_knows_every_command(shell, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--completion", shell])
    assert ended.value.code == 0
    script = capsys.readouterr().out
    assert all(name in script for name in COMMANDS)


COMPLETE = """source "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
$(complete -p exidyn | sed 's/.*-F \\([^ ]*\\).*/\\1/') exidyn "${COMP_WORDS[COMP_CWORD]}" "" 2> /dev/null
printf '%s\\n' "${COMPREPLY[@]}" """


@pytest.fixture(scope="module")
def script(tmp_path_factory) -> Path:
    import shtab

    folder = tmp_path_factory.mktemp("shell")
    (folder / "exidyn.bash").write_text(shtab.complete(parser_of_all(), "bash"))
    (folder / "run.mcap").write_text("")
    (folder / "results").mkdir()
    return folder / "exidyn.bash"


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("exidyn dia", "diagnose"),
        ("exidyn identify --val", "--validate"),
        ("exidyn identify ru", "run.mcap"),
        ("exidyn identify --output res", "results"),
        ("exidyn export fit.json --to mjc", "mjcf"),
        ("exidyn init --driver kuka", "kuka_rsi"),
    ],
)
def test_bash_completes(script, typed, expected):
    BASH.require()
    command = ["bash", "--norc", "-c", COMPLETE, str(script), *typed.split()]
    mentioned = subprocess.check_output(command, text=True, cwd=script.parent)
    assert mentioned.split() == [expected]
