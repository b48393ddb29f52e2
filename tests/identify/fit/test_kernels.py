"""The second pass of `check` runs the tests of arithmetic, and under another kernel."""

import pytest

from ...other_kernel import KERNELS, VARIABLE, other_kernel, running

pytestmark = pytest.mark.long


@pytest.mark.parametrize("preset", ["", "Nehalem"])
def test_the_other_kernel_is_another_one(preset, monkeypatch):
    if preset:
        monkeypatch.setenv(VARIABLE, preset)
    usual = running()
    if not usual or not any(running(kernel) != usual for kernel in sum(KERNELS.values(), ())):
        pytest.skip("numpy has no kernels to choose from here")
    assert running(other_kernel()) not in ("", usual)
