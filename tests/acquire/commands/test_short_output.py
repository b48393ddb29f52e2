"""Every command of docs/your-own-arm.md prints at most 25 lines of 80 columns for six joints."""

import re

import pytest

from exidyn.acquire.command_line import main
from exidyn.acquire.commands import COMMANDS
from exidyn.acquire.commands.result import LINES

pytestmark = pytest.mark.slow

BODY = "--mass 8 --com 0.1 0 0.1"
PLANNED = "--length 12 --iterations 1 --harmonics 4"
ON = "--robot robot.toml --controller cell.toml"
TUTORIAL = f"""example files --output .
excite robot.toml {BODY} {PLANNED}
excite robot.toml --seed 7 -o other.toml {PLANNED}
excite robot.toml --show trajectory.toml
watch {ON} --length 0.1
jog 3 {ON}
record trajectory.toml {ON} -o run.mcap
record trajectory.toml {ON} {BODY} -o loaded.mcap
record other.toml {ON} -o other.mcap
import log.csv --robot robot.toml --degrees
info run.mcap
identify log.mcap -o of-the-log
identify run.mcap --payload loaded.mcap {BODY} --validate other.mcap
diagnose log.mcap --quick
simulate exidyn-fit/fit.json other.toml
simulate sim.mcap --against other.mcap
simulate sim.mcap --against log.mcap --offset 0
view exidyn-diagnosis/diagnosis.json --save diagnosis.rrd
export exidyn-fit/fit.json --to mjcf
payload loaded.mcap --empty run.mcap
payload loaded.mcap --fit of-the-log/fit.json
contact other.mcap --fit exidyn-fit/fit.json
compensate exidyn-fit/fit.json"""
"""The tutorial's commands with short searches, and those of its further reading."""
PROGRESS = re.compile(r"^ +\d+\.\d s  .*\n(?: {10}\S.*\n)*", re.MULTILINE)
"""A sentence of progress, which a terminal shows on one line that is rewritten and removed."""
ONE_LINE = ("exidyn: ", "0.")
"""Beginnings of warnings and of readings of `watch`: one line in a pipe, and narrow in a terminal."""
ELSEWHERE = {"init", "gap"}
"""Commands whose output is long for other reasons: a file to keep, and a simulator."""


def test_a_command_prints_a_verdict_a_table_files_and_what_is_next(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["init", "--driver", "mock"]) == 0
    (tmp_path / "cell.toml").write_text(capsys.readouterr().out)
    shown = {}
    for command in TUTORIAL.splitlines():
        assert main(command.split()) == 0, capsys.readouterr().err
        shown[command] = PROGRESS.sub("", "".join(capsys.readouterr())).splitlines()
    assert {command.split()[0] for command in shown} == COMMANDS.keys() - ELSEWHERE
    counts = {command: sum(rows(line) for line in lines) for command, lines in shown.items()}
    assert {command: count for command, count in counts.items() if count > LINES} == {}
    wide = [line for lines in shown.values() for line in lines if rows(line) > 1]
    assert not [line for line in wide if not line.startswith(ONE_LINE)]


def rows(line):
    """Rows of a terminal of 80 columns."""
    return max(1, -(-len(line) // 80))
