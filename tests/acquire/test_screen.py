"""What a command prints has no control characters, whatever a file or its name holds."""

import io
import json
import sys
from contextlib import suppress
from dataclasses import replace

import pytest

from exidyn.acquire.command_line import main
from exidyn.acquire.screen import Screen, beneath, screens
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.quoting import CONTROL, one_line

from ..parts.small.two_joint_files import run

ESCAPES = "name \x1b]0;title\x07 \x1b[2J\x9b31m \x7f\x00 \u202e \r over \n line"


def clean(text):
    return not CONTROL.search(text.replace("\n", ""))


@pytest.fixture
def recording(tmp_path):
    recorded = run("run")
    robot = replace(recorded.robot, name=ESCAPES.replace("\0", ""))
    hostile = replace(
        recorded,
        name=ESCAPES,
        model=replace(recorded.model, robot=robot),
        settings={ESCAPES: ESCAPES},
        warnings=(ESCAPES,),
    )
    path = tmp_path / f"run {ESCAPES.replace(chr(0), '')}.mcap"
    write_recording(hostile, path)
    return path


def test_info_shows_control_characters_as_their_codes(recording, capsys):
    assert main(["info", str(recording)]) == 0
    captured = capsys.readouterr()
    assert clean(captured.out + captured.err)
    assert captured.out.startswith(f"{one_line(ESCAPES)}\n")


def test_json_on_the_screen_says_the_same_and_is_json(recording, capsys):
    assert main(["info", str(recording), "--json", "-"]) == 0
    out = capsys.readouterr().out
    assert clean(out)
    assert json.loads(out)["recordings"][0]["name"] == ESCAPES


@pytest.mark.parametrize(
    "arguments",
    [
        ["info", "\x1b[31mnowhere.mcap"],
        ["\x1b[31mcommand"],
        ["info", "--\x1b[31moption"],
        ["export", "bytes \udcff \x9b.json", "--to", "urdf"],
        ["excite", "\x1b[31m.toml", "--length", "10"],
    ],
)
def test_errors_show_control_characters_as_their_codes(arguments, capsys):
    with suppress(SystemExit):  # of argparse
        assert main(arguments) == 2
    err = capsys.readouterr().err
    assert err
    assert clean(err)


def test_a_screen_is_the_stream_but_for_control_characters():
    stream = io.StringIO()
    screen = Screen(stream)
    assert print("a\x1b[1m\tb\x85", file=screen) is None
    screen.writelines(["\r", "\ud800"])
    beneath(screen).write("\x1b[0m")
    assert stream.getvalue() == "a\\x1b[1m\tb\\x85\n\\x0d\\ud800\x1b[0m"
    assert screen.getvalue() == stream.getvalue()
    assert not screen.isatty()


def test_screens_are_there_for_a_command_only(monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)
    before = sys.stdout
    with screens():
        assert beneath(sys.stdout) is before
        assert sys.stdout is not before
        assert sys.stderr is None
        with screens():
            assert beneath(sys.stdout) is before
    assert sys.stdout is before
