"""The notebooks of docs run from their first cell to their last, and are stored as they ran."""

import ast
import json
import re
from pathlib import Path

import numpy as np
import pytest

import exidyn as ex

NOTEBOOKS = sorted((Path(__file__).parents[1] / "docs" / "notebooks").glob("*.ipynb"))


def code_of(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [cell for cell in cells if cell["cell_type"] == "code"]


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, tmp_path, monkeypatch):
    pytest.importorskip("pandas")
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for number, cell in enumerate(code_of(path)):
        exec(compile("".join(cell["source"]), f"{path.stem} cell {number + 1}", "exec"), names)
    assert list(tmp_path.glob("*.html"))
    fitted, judged = (names[name].signals["position"].values for name in ("log", "held_out"))
    assert fitted.shape != judged.shape or not np.allclose(fitted, judged, atol=0.1)
    if path.stem == "diagnose":
        findings = [(finding.effect, finding.joints) for finding in names["found"].findings]
        assert findings == [("load_dependent_friction", (1,))]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_as_it_ran_and_uses_functions_that_exist(path):
    cells = code_of(path)
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    outputs = [output for cell in cells for output in cell["outputs"]]
    assert len(outputs) >= len(cells) // 2
    assert not any(output["output_type"] == "error" for output in outputs)
    assert not any("Warning" in "".join(output.get("text", "")) for output in outputs)
    tree = ast.parse("\n".join("".join(cell["source"]) for cell in cells))
    uses = {ast.unparse(node) for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    functions = {use.removeprefix("ex.") for use in uses if re.fullmatch(r"ex\.\w+", use)}
    assert {"robot", "plan", "simulate", "report", path.stem} <= functions <= set(dir(ex))


def test_both_are_there():
    assert [path.stem for path in NOTEBOOKS] == ["diagnose", "identify"]
