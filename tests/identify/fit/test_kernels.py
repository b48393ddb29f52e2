"""The second pass of `check` runs the tests of arithmetic, and under another kernel."""

from pathlib import Path

import pytest

from ...conftest import FILES
from ...other_kernel import KERNELS, VARIABLE, other_kernel, running


def test_files_of_arithmetic_are_there():
    there = {file.name for file in Path(__file__).parents[2].rglob("test_*.py")}
    assert sorted(FILES - there) == []


@pytest.mark.parametrize("preset", ["", "Haswell", "Nehalem"])
def test_the_other_kernel_is_another_one(preset, monkeypatch):
    if preset:
        monkeypatch.setenv(VARIABLE, preset)
    usual = running()
    if not usual or not any(running(kernel) != usual for kernel in sum(KERNELS.values(), ())):
        pytest.skip("numpy has no kernels to choose from here")
    assert running(other_kernel()) not in ("", usual)
