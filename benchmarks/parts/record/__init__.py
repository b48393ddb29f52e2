"""Runs as `exidyn record` makes them, against the peers of the tests, by the clock of this machine."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[3]))
