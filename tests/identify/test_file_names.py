"""Names of files from any text: one component that every system takes, distinct where names are."""

from pathlib import Path, PurePosixPath, PureWindowsPath

import pytest

from exidyn.identification.file_names import LONGEST, distinct_stems, file_stem, looked_in, read_failure

HOSTILE = [
    "../../../PWNED", "/etc/passwd", "..", ".", "", "   ", "C:\\Windows\\x", "\\\\host\\share", "a/b", "-rf",
    "~root", ".hidden", "line\nbreak", "nul\0byte", "con", "CON.tar", "Lpt1", "COM¹", "ends.", "ends ",
    "é" * 200, "x" * 5000, "\ud800", "a:stream", "*?<>|\"",
]  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("make", [file_stem, lambda name: distinct_stems([name])[0]])
def test_a_stem_is_one_visible_component_that_every_system_takes(make, name, tmp_path):
    stem = make(name)
    assert PurePosixPath(stem).parts == PureWindowsPath(stem).parts == (stem,)
    assert not PureWindowsPath(f"{stem}.toml").is_reserved()
    assert not stem.startswith((".", "-"))
    assert not stem.endswith((".", " "))
    assert len(stem.encode()) <= LONGEST
    (tmp_path / stem).write_text("")
    assert [path.name for path in tmp_path.iterdir()] == [stem]


@pytest.mark.parametrize("name", ["two_joints", "KR270-2", "welding.07", "Größe_3", "run_1"])
def test_a_plain_name_stays(name):
    assert file_stem(name) == name


def test_what_is_left_empty_gets_the_default():
    assert file_stem("../..", "robot") == "robot"
    assert file_stem("nul", "robot") == "robot_nul"


def test_names_that_differ_have_stems_that_differ_on_every_disk():
    names = [*HOSTILE, "a b", "a_b", "A_B", "a_b_1", "a:b", "x" * 4999 + "y"]
    stems = distinct_stems(names)
    assert len({stem.casefold() for stem in stems}) == len(names)
    assert distinct_stems(["run", "run", "Run"]) == ["run", "run_1", "Run_2"]


def test_a_missing_file_is_reported_with_its_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert looked_in(Path("run.mcap")) == f"; looked in {tmp_path}"
    assert looked_in(Path("none/run.mcap")) == f"; there is no folder {tmp_path / 'none'}"
    missing, refused = FileNotFoundError(2, "No such file"), PermissionError(13, "Permission denied")
    assert read_failure(Path("run.mcap"), missing) == f"No such file; looked in {tmp_path}"
    assert read_failure(Path("run.mcap"), refused) == "Permission denied"
