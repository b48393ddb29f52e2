"""MATLAB files: version 5 by scipy, 7.3, which is HDF5, by h5py (extra `exidyn[hdf5]`)."""

from pathlib import Path

from .damage import refused_as
from .hdf5_file import read_hdf5
from .tables.table import Table, table_of

HDF5 = b"\x89HDF"
"""How an HDF5 file begins, or one of MATLAB behind its own 512 bytes."""


def read_matlab(source: Path) -> list[Table]:
    """Read variables; a field of a structure is called by both names, such as `data.q`.

    Raises:
        NotAFile: It is no such file, or holds no arrays of numbers.
        MissingPackage: h5py is needed and not installed.
    """
    from scipy.io import loadmat

    with open(source, "rb") as file:
        begin = file.read(512 + len(HDF5))
    if HDF5 in (begin[: len(HDF5)], begin[512:]):
        return read_hdf5(source, between=".")
    with refused_as(source, "a MATLAB file"):
        return [table_of(source, loadmat(source))]
