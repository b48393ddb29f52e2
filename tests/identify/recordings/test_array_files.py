"""Files of arrays, written by the libraries that define them: MATLAB, HDF5, Parquet and NumPy."""

from pathlib import Path

import numpy as np
import pytest
import scipy.io

from exidyn.identification.errors import ExidynError, MissingPackage, NotAFile
from exidyn.identification.recordings.importers import import_source, read_tables

from ...parts.runs.runs import TIME, model, motion, noise, require

ARRAYS = {"t": TIME, "q": motion(), "i": noise(), "gear": np.array([100.0, -50.0]), "note": "free"}


def write_npz(path: Path, arrays) -> None:
    np.savez_compressed(path, **arrays)


def write_mat(path: Path, arrays) -> None:
    scipy.io.savemat(path, arrays)


def write_hdf5(path: Path, arrays) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, array in arrays.items():
            file[name] = array


def write_mat73(path: Path, arrays) -> None:
    """As MATLAB: behind a text of 512 bytes, matrices transposed, texts as numbers."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, array in arrays.items():
            stored = np.frombuffer(array.encode("utf-16-le"), "u2") if isinstance(array, str) else array
            file[name] = np.atleast_2d(stored.T)
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512))


def write_parquet(path: Path, arrays) -> None:
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    table = {name: arrow.array(list(arrays[name])) for name in ("t", "q", "i")}
    table["note"] = arrow.array([arrays["note"]] * len(arrays["t"]))
    parquet.write_table(arrow.table(table), path)


WRITERS = {
    "run.npz": write_npz,
    "run.mat": write_mat,
    "run73.mat": write_mat73,
    "run.h5": write_hdf5,
    "run.parquet": write_parquet,
}


@pytest.mark.parametrize("name", WRITERS)
def test_arrays_are_columns_named_by_their_place(tmp_path, name, in_process):
    WRITERS[name](tmp_path / name, ARRAYS | {"q": np.degrees(motion()), "t": 1e3 * TIME})
    [table] = read_tables(tmp_path / name)
    assert sorted(table.names) == ["i1", "i2", "q1", "q2", "t"]
    assert np.array_equal(table.values[:, table.names.index("q2")], np.degrees(motion()[:, 1]))
    [found] = import_source(tmp_path / name, model(), degrees=True, units={"time": "ms"})
    assert found.name == name.partition(".")[0]
    assert set(found.signals) == {"position", "current"}
    require(found, position=motion(), atol=1e-15)
    require(found, time=TIME, atol=1e-9)
    require(found, current=noise())


def test_structures_and_groups(tmp_path, in_process):
    inner = {"time": TIME[:, None], "arm": {"pos": motion(), "amps": noise().T}}
    scipy.io.savemat(tmp_path / "run.mat", {"log": inner, "cells": np.array(["a", "b"], dtype=object)})
    columns = {"time": "log.time", "position": "log.arm.pos", "current": ["log.arm.amps1", "log.arm.amps2"]}
    [found] = import_source(tmp_path / "run.mat", model(), columns=columns)
    require(found, current=noise())
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["log/time"], file["log/arm/pos"], file["log/arm/amps"] = TIME, motion(), noise()
        file["log/camera"], file["log/map"] = np.zeros((len(TIME), 4, 4, 3), "u1"), np.zeros((480, 640))
        file["log/self"] = file["log"]
    columns = {"time": "log/time", "position": "log/arm/pos", "current": "log/arm/amps{number}"}
    [found] = import_source(tmp_path / "run.h5", model(), columns=columns)
    require(found, position=motion())


def test_records_and_dates(tmp_path, in_process):
    kind = [("t", "M8[us]"), ("q1", float), ("q2", float), ("i1", "f4"), ("i2", "f4")]
    rows = np.zeros(len(TIME), kind)
    rows["t"] = np.datetime64("2026-03-01T12:00:00") + np.rint(TIME * 1e6).astype("m8[us]")
    rows["q1"], rows["q2"] = motion().T
    rows["i1"], rows["i2"] = noise().T
    np.savez(tmp_path / "run.npz", run=rows)
    columns = {"time": "run.t", "position": "run.q{number}", "current": "run.i{number}"}
    [found] = import_source(tmp_path / "run.npz", model(), columns=columns)
    require(found, time=TIME, atol=1e-6)
    require(found, current=noise().astype("f4"))


@pytest.mark.parametrize("name", WRITERS)
def test_a_damaged_file_is_refused(tmp_path, name, in_process):
    path = tmp_path / {"run.parquet": "run.pq", "run.h5": "run.hdf5"}.get(name, name)
    begun = {".mat": b"MATLAB 5.0 MAT-file".ljust(128, b"\0"), ".npz": b"PK\x03\x04"}
    for content in (b"", begun.get(path.suffix, b"PAR1 \x89HDF")):
        path.write_bytes(content)
        with pytest.raises(NotAFile, match=r"cannot be read as|holds no arrays of numbers"):
            import_source(path, model())
    WRITERS[name](path, ARRAYS)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) - 100])
    with pytest.raises(ExidynError):
        import_source(path, model())


def test_objects_in_a_numpy_file_are_not_run(tmp_path):
    np.savez(tmp_path / "run.npz", t=np.array([print, print], dtype=object))
    with pytest.raises(NotAFile, match=r"t holds Python objects, .* Save numbers: np.array\(t, float\)"):
        import_source(tmp_path / "run.npz", model())


@pytest.mark.parametrize(
    ("name", "package", "extra"),
    [("run.h5", "h5py", "hdf5"), ("run73.mat", "h5py", "hdf5"), ("run.parquet", "pyarrow", "parquet")],
)
def test_a_library_that_is_missing_is_named_with_its_extra(tmp_path, monkeypatch, name, package, extra):
    WRITERS[name](tmp_path / name, ARRAYS)
    stub = tmp_path / "stubs" / f"{package}.py"  # of the process that reads
    stub.parent.mkdir()
    stub.write_text(f"raise ModuleNotFoundError('No module named {package}')")
    monkeypatch.syspath_prepend(stub.parent)
    with pytest.raises(MissingPackage, match=rf'needs {package}, .*: pip install "\.\[{extra}\]"'):
        import_source(tmp_path / name, model())


@pytest.mark.parametrize("version", ["6.1_SOL2", "7.4_GLNX86"])
def test_files_that_matlab_wrote(version, in_process):
    """Of scipy's own tests, if they are installed."""
    folder = Path(scipy.io.matlab.__file__).parent / "tests" / "data"
    if not folder.is_dir():
        pytest.skip("scipy was installed without its tests")
    [table] = read_tables(folder / f"teststruct_{version}.mat")
    assert table.names == ["teststruct.doublefield"]
    np.testing.assert_allclose(table.values[:, 0], [np.sqrt(2), np.exp(1), np.pi])
    pytest.importorskip("h5py")
    [table] = read_tables(folder / "testhdf5_7.4_GLNX86.mat")
    np.testing.assert_allclose(table.values[:, 0], np.arange(9) * np.pi / 4)
