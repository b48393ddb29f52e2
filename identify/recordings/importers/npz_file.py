"""NumPy files with several arrays (.npz)."""

from pathlib import Path

import numpy as np

from .damage import refused_as
from .tables.table import Table, table_of


def read_npz(source: Path) -> list[Table]:
    """Read arrays as `numpy.savez` and `savez_compressed` write them; objects are refused.

    Raises:
        NotAFile: It is no such file, or holds no arrays of numbers.
    """
    with refused_as(source, "a NumPy file"), open(source, "rb") as file, np.load(file) as arrays:
        return [table_of(source, dict(arrays))]
