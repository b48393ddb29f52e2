"""The pages of docs: command lines that parse, files and options that exist, links that resolve."""

import argparse
import re
import shlex
from pathlib import Path

import pytest

from exidyn.acquire.command_line import SHELLS
from exidyn.acquire.commands import COMMANDS, command
from exidyn.identification.diagnosis.candidates import KINDS
from exidyn.identification.effects import EFFECTS

ROOT = Path(__file__).parents[3]
README = ROOT / "README.md"
PAGES = [README, ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
COMMAND = re.compile(r"\bexidyn ([a-z]+)\b([^`|>\n#]*)")
LINK = re.compile(r"\]\((?!https?:)([^)#]*)(?:#([^)]*))?\)")
BLOCK = re.compile(r"^ *```sh(?: title=\"[^\"]*\")?\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
"""A block of the shell; a title states where it is run, such as on the robot."""
FILE = re.compile(r"[\w./-]+\.(?:toml|mcap|csv|json|urdf|xml)\b")
YOUR_ARM = ROOT / "docs" / "your-own-arm.md"
DEFAULTS = {"exidyn-example", "exidyn-fit", "exidyn-diagnosis"}
"""Folders that commands make unless told otherwise."""
WRITES = ("-o", "--output", "--json", "--save", ">")


def shell_lines(page: Path) -> list[str]:
    """What a page has to type, continued lines joined."""
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    return [line for block in BLOCK.findall(text) for line in block.splitlines()]


def words_of(line: str) -> list[str]:
    """Words of a shell line; pipes and redirections are words of their own, comments are left out."""
    words = shlex.shlex(line, posix=True, punctuation_chars="|>&;")
    words.whitespace_split = True
    return list(words)


def commands(line: str) -> list[list[str]]:
    """The words behind each `exidyn` of a shell line."""
    found: list[list[str]] = []
    inside = False
    for word in words_of(line):
        if word in ("exidyn", ".venv/bin/exidyn"):
            found.append([])
            inside = True
        elif word[0] in "|>&;":
            inside = False
        elif inside:
            found[-1].append(word)
    return found


def named(page: Path) -> set[str]:
    """The files that the text and the comments of a page name."""
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    comments = [line.partition(" #")[2] for line in shell_lines(page)]
    return set(FILE.findall("\n".join([text, *comments])))


def options(parser: argparse.ArgumentParser) -> set[str]:
    return {option for action in parser._actions for option in action.option_strings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_command_lines_of_pages_are_understood(page):
    for line in shell_lines(page):
        for name, *rest in commands(line):
            if name == "--completion":
                assert rest[0] in SHELLS
                continue
            try:
                command(name).parser().parse_args(rest)
            except SystemExit:
                pytest.fail(line)


def test_command_lines_are_found():
    assert commands("sleep 9 | python x.py & exidyn info 'a b.mcap' --json - | cat  # exidyn view") == [
        ["info", "a b.mcap", "--json", "-"]
    ]
    assert sum(len(commands(line)) for page in PAGES for line in shell_lines(page)) > 90


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages_name_no_file_that_comes_from_nowhere(page):
    """Each is written by a line before, named in the text, or one of a walk to which the page leads."""
    known = DEFAULTS | named(page)
    if page == YOUR_ARM or YOUR_ARM.name in page.read_text(encoding="utf-8"):
        known |= named(YOUR_ARM) | {word for line in shell_lines(YOUR_ARM) for word in words_of(line)}
    for line in shell_lines(page):
        words = words_of(line)
        known |= {word for before, word in zip(words, words[1:], strict=False) if before in WRITES}
        read = {word for command in commands(line) for word in command if FILE.fullmatch(word)}
        assert not [file for file in read if not {file, file.partition("/")[0]} & known], line


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_options_that_pages_name_exist(page):
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    for name, rest in COMMAND.findall(text):
        if name in COMMANDS:
            mentioned = set(re.findall(r"(?<!\S)--?[a-z][a-z-]*", rest))
            assert mentioned <= options(command(name).parser()), f"exidyn {name}{rest}"
    every = set().union(*(options(command(name).parser()) for name in COMMANDS))
    alone = set(re.findall(r"`(--[a-z][a-z-]*)", text))
    others = "--arm --completion --arms --resume --bare --fifo --keep --quick --version"
    assert alone <= {*every, *others.split()}  # those of benchmarks, of peers, and of all commands


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_peers_of_pages_know_their_options_and_keep_their_output(page):
    """What a peer prints goes into a file, and not between the lines of the command that runs beside it."""
    for line in shell_lines(page):
        words = words_of(line)
        for script in (word for word in words if word.startswith("tests/peers/") and word.endswith(".py")):
            source = (ROOT / script).read_text(encoding="utf-8")
            imported = re.findall(r"^(?:from|import) (\w+)", source, re.MULTILINE)
            shared = [
                place for name in imported if (place := (ROOT / script).with_name(f"{name}.py")).exists()
            ]
            source += "".join(place.read_text(encoding="utf-8") for place in shared)
            given = words[words.index(script) :]
            taken = re.findall(r'"(--[a-z-]+)"', source)
            assert {word for word in given if word.startswith("--")} <= set(taken), line
            assert ">" in given, line


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_between_pages_lead_somewhere(page):
    for place, heading in LINK.findall(page.read_text(encoding="utf-8")):
        target = page.parent / place if place else page
        assert target.exists(), place
        if heading:
            lines = target.read_text(encoding="utf-8").splitlines()
            titles = {line.lstrip("# ").lower().replace(" ", "-") for line in lines if line.startswith("#")}
            assert heading in titles


@pytest.mark.parametrize("listing", ["docs/README.md", "mkdocs.yml"])
def test_every_page_is_listed(listing):
    listed = {"README.md", *re.findall(r"[\w-]+\.md", (ROOT / listing).read_text(encoding="utf-8"))}
    assert {page.name for page in (ROOT / "docs").glob("*.md")} <= listed


def test_pages_are_few_and_short():
    pages = [page.read_text(encoding="utf-8").split() for page in (ROOT / "docs").glob("*.md")]
    assert len(pages) <= 26
    assert sum(map(len, pages)) <= 40_000


def test_every_effect_that_outputs_name_is_explained():
    text = (ROOT / "docs" / "effects.md").read_text(encoding="utf-8")
    explained = re.findall(r"^\*\*(\w+)\*\*", text, re.MULTILINE)
    assert len(explained) == len(set(explained))
    assert set(explained) == {*EFFECTS, *KINDS, "unexplained"}
