"""Every benchmark that a page names runs to its end with --quick, and its figures are finite."""

import json
import math
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .parts.runs.runs import DATA

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
NAMED = re.compile(r"\bbenchmarks/(\w+)\.py\b")
NAMES = sorted({name for page in PAGES for name in NAMED.findall(page.read_text(encoding="utf-8"))})
"""Benchmarks that README, CONTRIBUTING and docs name."""
LONGEST = 1200.0
"""Time after which a benchmark has hung [s]. On a busy core, the longest takes six minutes."""
FOLDERS = {
    **dict.fromkeys(("real", "diagnose_real", "injected"), (DATA, "EXIDYN_DATA")),
    "simulator": (DATA / "mjcf", "EXIDYN_DATA"),
}
"""Benchmark -> folder without which it measures nothing, and the variable that names the data."""
PACKAGES = {
    "simulate": ("mujoco",),
    "simulator": ("mujoco",),
    "contact": ("mujoco",),
    "record": ("can", "msgpack", "serial"),
}
"""Benchmark -> packages of extras without which it cannot run."""
UNMEASURED = {"concealed": {"outside", "by_strength"}, "contact": {"touches"}}
"""Benchmark -> figures that a quick run leaves open (NaN), and tables whose classes have no upper end."""
REQUIRED = {
    "concealed": {"top1": 1.0, "false_alarms": 0},
    "diagnose_real": {"known_named_percent": 100.0, "false_names": 0},
    "excite": {"limit_violations": 0},
    "own_logs": {"false_refusals": 0, "false_certain": 0, "init_fails": 0},
    "simulator": {"refused": 0, "false": 0, "changed_for_nothing": 0, "file_worse_than_original": 0},
}
"""Benchmark -> figures of a quick run that anything else than this value would spoil."""
CLOCKED = {"record"}
"""Benchmarks with peers that keep to the clock."""


def numbers_in(figures: Any) -> Iterator[float]:
    """All numbers in tables and lists, at any depth."""
    if isinstance(figures, dict | list):
        for value in figures.values() if isinstance(figures, dict) else figures:
            yield from numbers_in(value)
    elif isinstance(figures, int | float) and not isinstance(figures, bool):
        yield figures


def parameters() -> list[Any]:
    return [pytest.param(name, marks=[pytest.mark.clocked] * (name in CLOCKED), id=name) for name in NAMES]


def test_the_pages_name_the_benchmarks():
    assert {"kr270", "concealed", "simulator"} <= set(NAMES)
    assert [name for name in NAMES if not (ROOT / "benchmarks" / f"{name}.py").is_file()] == []


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", parameters())
def test_a_benchmark_runs_with_quick(name, tmp_path):
    for package in PACKAGES.get(name, ()):
        pytest.importorskip(package)
    folder, variable = FOLDERS.get(name, (ROOT, ""))
    if not folder.is_dir():
        pytest.skip(f"no data in {folder}; set {variable} to the folder of the data")
    file = tmp_path / "figures.json"
    command = [sys.executable, f"benchmarks/{name}.py", "--quick", "--json", str(file)]
    environment = os.environ | {"EXIDYN_DATA": str(DATA.resolve())}
    done = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=LONGEST, check=False
    )
    assert done.returncode == 0, f"{done.stdout[-1000:]}\n{done.stderr[-3000:]}"
    figures = json.loads(file.read_text(encoding="utf-8"))
    assert list(numbers_in(figures))
    infinite = {key for key, value in figures.items() if not all(map(math.isfinite, numbers_in(value)))}
    assert infinite <= UNMEASURED.get(name, set())
    required = REQUIRED.get(name, {})
    assert {key: figures[key] for key in required} == required
