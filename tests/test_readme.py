"""README's Python lines run as they stand, and the page stays short."""

import re
from pathlib import Path

import pytest

import exidyn as ex
from exidyn.identification.export import FORMATS, Portable

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
LONGEST = 110
"""Lines of a first page that is read to its end."""


def test_the_first_page_is_short():
    assert len(README.splitlines()) <= LONGEST


@pytest.mark.slow
def test_the_lines_of_python_run_as_a_plain_script(tutorial, tmp_path, monkeypatch, capsys):
    [lines] = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len([line for line in lines.splitlines() if line]) <= 12
    monkeypatch.chdir(tmp_path)
    run, model = ex.read(tutorial / "run.mcap"), ex.robot(tutorial / "robot.toml")
    monkeypatch.setattr(ex, "diagnose", lambda run: ex.load(tutorial / "diagnosis" / "diagnosis.json"))
    position, current = run.signals["position"], run.signals["current"]
    Path("arm.urdf").write_text(FORMATS["urdf"].text(Portable.of(model)))
    names = {"t": position.time, "q": position.values, "torque": current.values * model.robot.drive_gain}
    exec(lines, names)
    printed = capsys.readouterr().out
    assert "base parameters were identified" in printed
    assert "has a spring that the model does not have" in printed
    assert Path("arm.xml").stat().st_size > 1000
    assert "namespace" in Path("arm.hpp").read_text()
