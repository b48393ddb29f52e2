"""README's Python lines run as they stand, and the page stays short."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from exidyn.identification.export import FORMATS, Portable

from .parts.small.small_diagnosis import nominal_model, recording

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
LONGEST = 120
"""Lines of a first page that is read to its end."""
ARRAYS = "import numpy as np\nt, q, torque = (np.load(f'{name}.npy') for name in ('t', 'q', 'torque'))\n"


def test_the_first_page_is_short():
    assert len(README.splitlines()) <= LONGEST


@pytest.mark.slow
def test_the_lines_of_python_run_in_a_plain_script(tmp_path):
    [lines] = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len([line for line in lines.splitlines() if line]) <= 12
    run, model = recording("identify", 0), nominal_model()
    current = run.signals["current"]
    np.save(tmp_path / "t.npy", current.time)
    np.save(tmp_path / "q.npy", run.signals["position"].values)
    np.save(tmp_path / "torque.npy", current.values * model.robot.drive_gain)
    (tmp_path / "arm.urdf").write_text(FORMATS["urdf"].text(Portable.of(model)))
    (tmp_path / "script.py").write_text(ARRAYS + lines)
    command = [sys.executable, "script.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "base parameters were identified" in done.stdout
    assert (tmp_path / "arm.xml").stat().st_size > 1000
