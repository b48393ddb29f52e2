"""What tests need from the operating system: a machine without it is told, and the documentation lists it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from .parts.system_needs import INSTALLABLE, Need

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "tests" / "parts" / "system_needs.py"


@pytest.mark.skipif(sys.platform != "linux", reason="names Debian packages")
def test_a_machine_without_programs_and_drivers_lacks_every_package(tmp_path):
    hidden = {"PATH": str(tmp_path), "VK_DRIVER_FILES": str(tmp_path), "VK_ICD_FILENAMES": str(tmp_path)}
    command = [sys.executable, SCRIPT]
    output = subprocess.check_output(command, text=True, env={**os.environ, **hidden})
    assert output.split() == [package for need in INSTALLABLE for package in need.packages]


def test_a_test_skips_with_the_package_to_install():
    with pytest.raises(pytest.skip.Exception, match="no hammer; apt-get install hammer nails"):
        Need(("hammer", "nails"), lambda: "no hammer").require()
    Need(("hammer",), lambda: "").require()


def test_contributors_find_every_package():
    rows = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").splitlines()
    for need in INSTALLABLE:
        assert any(row.startswith(f"| `{' '.join(need.packages)}` |") for row in rows), need.packages
