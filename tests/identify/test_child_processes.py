"""Children end with the process that started them, however that ends."""

import os
import signal
import subprocess
import sys
import time

import pytest

from exidyn.identification.child_processes import process_pool, start_program

from ..parts.descendants import started, within

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")

POOL = """
import sys, time
from pathlib import Path
from exidyn.identification.child_processes import process_pool
if __name__ == "__main__":
    with process_pool(2) as pool:
        list(pool.map(abs, range(100)))
        Path(sys.argv[1]).touch()
        [pool.submit(time.sleep, 600.0) for _ in range(2)]
        time.sleep(600.0)
"""
PROGRAM = """
import subprocess, sys, time
from pathlib import Path
from exidyn.identification.child_processes import start_program
start_program([sys.executable, "-c", "import time; time.sleep(600.0)"], subprocess.DEVNULL, {lives_on})
Path(sys.argv[1]).touch()
time.sleep(600.0)
"""
PATIENCE = 60.0
"""Of a busy machine, until processes have started or ended [s]."""


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
@pytest.mark.parametrize("early", [True, False])
@pytest.mark.parametrize(("script", "count"), [(POOL, 4), (PROGRAM.format(lives_on=False), 2)])
def test_no_child_outlives_its_parent(script, count, early, how, tmp_path):
    """Whether children have only just been started, or work already."""
    path, works = tmp_path / "script.py", tmp_path / "works"
    path.write_text(script)
    with started([str(path), str(works)]) as run:
        assert within(PATIENCE, lambda: len(run.alive()) == count and (early or works.exists()))
        run.process.send_signal(how)
        run.process.wait()
        assert within(PATIENCE, lambda: not run.alive())


def test_a_program_that_is_to_live_on_does(tmp_path):
    path = tmp_path / "script.py"
    path.write_text(PROGRAM.format(lives_on=True))
    with started([str(path), str(tmp_path / "works")]) as run:
        assert within(PATIENCE, lambda: len(run.alive()) == 2)
        run.process.kill()
        run.process.wait()
        time.sleep(1.0)
        # A process that is just becoming another program has no environment for a moment.
        assert within(PATIENCE, run.alive)


def test_a_child_of_a_parent_that_has_gone_ends_at_once(tmp_path):
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    code = "from exidyn.identification.child_processes import end_with_parent"
    code += f"; end_with_parent({gone.pid}, input)"
    assert (
        subprocess.run([sys.executable, "-c", f"{code}; import os; os._exit(7)"], check=False).returncode == 1
    )


def test_a_pool_calls_its_initializer():
    with process_pool(1, os.putenv, ("MARKED", "yes")) as pool:
        assert pool.submit(subprocess.getoutput, "echo $MARKED").result() == "yes"


def test_a_program_prints_and_has_signals_that_its_parent_ignores(tmp_path):
    code = "import signal; print(signal.getsignal(signal.SIGTERM) == signal.SIG_DFL)"
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with (tmp_path / "out").open("wb") as out:
            process = start_program([sys.executable, "-c", code], out)
            assert process.wait() == 0
            process.stdin.close()
    finally:
        signal.signal(signal.SIGTERM, before)
    assert (tmp_path / "out").read_text() == "True\n"
