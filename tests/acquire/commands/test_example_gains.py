"""The first example, whole: what it records is identified, and is the truth."""

import pytest

from exidyn.acquire.command_line import main

pytestmark = pytest.mark.clocked(patient=True)


def test_the_example_finds_the_truth(tmp_path, capsys):
    assert main(["example", "--length", "20", "--output", str(tmp_path)]) == 0
    printed, progress = capsys.readouterr()
    assert f"exidyn identify {tmp_path}/unloaded.mcap --payload {tmp_path}/loaded.mcap --mass 175" in progress
    lines = [line.split() for line in printed.partition("Identified and true values")[2].splitlines() if line]
    gains = [line for line in lines if line[0] == "drive"]
    assert len(gains) == 6
    assert all(abs(float(line[-3])) < 3.0 for line in gains)  # % of truth; nominal is 10 % wrong
    assert all(abs(float(line[-1])) < 4.0 for line in gains)  # standard deviations: one draw in a thousand
    spring = [line for line in lines if line[0] == "spring"]
    assert len(spring) == 2
    assert all(abs(float(line[-1])) < 3 for line in spring)  # deviations
