"""HDF5 files, through the package h5py (extra `exidyn[hdf5]`)."""

from pathlib import Path
from typing import Any

from ...notebook import optional
from .damage import refused_as
from .tables.table import Table, table_of


def read_hdf5(source: Path, between: str = "/") -> list[Table]:
    """Read data sets; what lies in groups is called by its path, such as `arm/q`.

    Raises:
        NotAFile: It is no such file, or holds no arrays of numbers.
        MissingPackage: h5py is not installed.
    """
    h5py = optional("h5py", "an HDF5 file", "hdf5")
    arrays: dict[str, Any] = {}

    def collect(name: str, found: Any) -> None:
        if isinstance(found, h5py.Dataset) and not name.startswith("#"):  # #refs# is MATLAB's
            arrays[name.replace("/", between)] = found

    with refused_as(source, "HDF5"), h5py.File(source) as file:
        file.visititems(collect)
        return [table_of(source, arrays, between)]
