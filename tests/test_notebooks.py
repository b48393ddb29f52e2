"""The notebooks of docs run from their first cell to their last."""

import json
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

NOTEBOOKS = sorted((Path(__file__).parents[1] / "docs" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, tmp_path, monkeypatch):
    pytest.importorskip("pandas")
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    names: dict[str, object] = {}
    for number, cell in enumerate(cell for cell in cells if cell["cell_type"] == "code"):
        assert cell["outputs"] == []
        exec(compile("".join(cell["source"]), f"{path.stem} cell {number + 1}", "exec"), names)
    assert list(tmp_path.glob("*.html"))
    if path.stem == "diagnose":
        found = names["found"]
        assert [(one.effect, one.joints) for one in found.findings] == [("load_dependent_friction", (1,))]


def test_there_are_two():
    assert [path.stem for path in NOTEBOOKS] == ["diagnose", "identify"]
