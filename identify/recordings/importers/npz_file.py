"""NumPy files with several arrays (.npz)."""

from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from ...errors import NotAFile
from .tables.table import Table, table_of


def read_npz(source: Path) -> list[Table]:
    """Read arrays as `numpy.savez` and `savez_compressed` write them; objects are refused.

    Raises:
        NotAFile: It is no such file, or holds no arrays of numbers.
    """
    try:
        with open(source, "rb") as file, np.load(file) as arrays:
            return [table_of(source, dict(arrays))]
    except (OSError, EOFError, ValueError, BadZipFile, AttributeError, TypeError) as error:
        raise NotAFile(f"{source} cannot be read as a NumPy file: {error}") from error
