"""Runs as `exidyn record` makes them, against peers, with faults, with kills.

In: a driver, a job, something that goes wrong.
Out: figures of the run and of its recording. Peers and damaged files are those of the tests.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]

sys.path += [str(ROOT / "tests" / "peers"), str(ROOT)]
