"""Distinguishing models by a run that is made for it: the last part of `excite.py`, alone."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy

from common import options, save
from parts.excite import discriminate

if __name__ == "__main__":
    chosen = options(discriminate.__doc__ or "")
    save(chosen.json, discriminate.run(chosen.quick))
