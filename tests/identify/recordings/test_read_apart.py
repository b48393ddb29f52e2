"""Libraries in native code read in a process apart: what kills them is one line, and kills nothing else."""

import os
import signal
import sys

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.errors import NotAFile
from exidyn.identification.recordings import reading_limits
from exidyn.identification.recordings.importers import read_tables

from ...parts.descendants import started, within

PATIENCE = 60.0
"""Of a busy machine, until processes have started or ended [s]."""


@pytest.fixture
def library(tmp_path, monkeypatch):
    """Puts code in place of the library that reads HDF5; returns the path of a file for it to read."""

    def made_of(code):
        (tmp_path / "stubs").mkdir()
        (tmp_path / "stubs" / "h5py.py").write_text(code)
        monkeypatch.syspath_prepend(tmp_path / "stubs")
        (tmp_path / "run.h5").write_bytes(b"\x89HDF")
        return tmp_path / "run.h5"

    return made_of


@pytest.mark.parametrize(
    ("code", "how"),
    [
        ("import ctypes; ctypes.string_at(0)", r"crashed \(SIGSEGV\)"),
        ("import os; os._exit(3)", r"ended with code 3"),
        ("import os; os.write(1, b'garbage'); os.abort()", r"crashed \(SIGABRT\)"),
        ("raise RuntimeError('no such thing')", r"ended with code 1 \(RuntimeError: no such thing\)"),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="has no signals")
def test_a_library_that_dies_is_one_line_with_file_and_library(library, code, how):
    with pytest.raises(NotAFile, match=rf"run\.h5: its reader, h5py, {how}.*: the file is damaged"):
        read_tables(library(code))


def test_a_library_that_does_not_come_to_an_end_is_ended(library, monkeypatch):
    monkeypatch.setattr(reading_limits, "START", 1.0)
    with pytest.raises(NotAFile, match="its reader, h5py, took more than 1 s"):
        read_tables(library("import time; time.sleep(600.0)"))


@pytest.mark.skipif(sys.platform != "linux", reason="limits memory on Linux")
def test_memory_beyond_the_limit_is_refused(library, monkeypatch, capsys):
    path = library("held = bytearray(1_000_000_000)")
    with pytest.raises(NotAFile, match="its content exceeds 200 MB"):
        read_tables(path)
    assert main(["import", str(path), "--robot", "kr270"]) == REFUSED
    [line] = capsys.readouterr().err.splitlines()
    assert line.endswith(f"state a larger limit in bytes: {reading_limits.VARIABLE}=1000000000")
    monkeypatch.setenv(reading_limits.VARIABLE, "1000000000")
    with pytest.raises(NotAFile, match="cannot be read as HDF5"):  # by that module, which took what it wanted
        read_tables(path)


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
def test_the_reader_ends_with_the_command(library, tmp_path):
    path = library("import os, pathlib, time; pathlib.Path(os.environ['BEGUN']).touch(); time.sleep(600.0)")
    begun = tmp_path / "begun"
    code = f"from exidyn.identification.recordings.importers import read_tables; read_tables({str(path)!r})"
    modules = os.pathsep.join([str(path.parent / "stubs"), *filter(None, sys.path)])
    with started(["-c", code], PYTHONPATH=modules, BEGUN=str(begun)) as command:
        assert within(PATIENCE, begun.exists)
        assert len(command.alive()) == 2
        command.process.send_signal(signal.SIGKILL)
        command.process.wait()
        assert within(PATIENCE, lambda: not command.alive())


def test_an_error_of_the_system_stays_what_it_is(tmp_path):
    (tmp_path / "run.mat").mkdir()
    with pytest.raises(IsADirectoryError) as caught:
        read_tables(tmp_path / "run.mat", "matlab")
    assert caught.value.filename == str(tmp_path / "run.mat")


def test_a_library_of_the_working_folder_is_not_imported(tmp_path, monkeypatch):
    scipy_io = pytest.importorskip("scipy.io")
    values = np.random.default_rng(0).normal(size=(50, 3))
    scipy_io.savemat(tmp_path / "run.mat", {"q": values})
    (tmp_path / "scipy.py").write_text("raise SystemExit(9)")
    monkeypatch.chdir(tmp_path)
    [table] = read_tables("run.mat")
    assert table.names == ["q1", "q2", "q3"]
    np.testing.assert_array_equal(table.values, values)
