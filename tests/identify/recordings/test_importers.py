"""Which importer reads what."""

import pytest

from exidyn.identification.errors import ExidynError, NotAFile, UnknownKey
from exidyn.identification.recordings.importers import IMPORTERS, import_source
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import Recording, Signal

from ...parts.runs.runs import TIME, model, motion, noise, require, table


@pytest.mark.parametrize("name", IMPORTERS)
def test_every_importer_in_the_table_can_be_called(name, tmp_path):
    # Nothing is there to read, so that each one must report it in our words.
    empty = tmp_path / "empty"
    empty.write_bytes(b"")
    with pytest.raises(ExidynError):
        import_source(empty, model(), kind=name)


def test_a_source_that_is_nothing_lists_what_can_be(tmp_path):
    (tmp_path / "robot.stl").write_text("solid")
    with pytest.raises(NotAFile, match="Known formats: CSV"):
        import_source(tmp_path / "robot.stl", model())
    with pytest.raises(NotAFile, match="does not exist"):
        import_source(tmp_path / "nothing.csv", model())
    with pytest.raises(UnknownKey, match="unknown key 'excel'"):
        import_source(tmp_path / "robot.stl", model(), kind="excel")


def test_a_folder_of_folders_names_those_that_can_be_imported(tmp_path):
    for bag in ("first", "second"):
        (tmp_path / bag).mkdir()
        (tmp_path / bag / "metadata.yaml").write_text("")
    (tmp_path / "notes").mkdir()
    with pytest.raises(NotAFile, match="these folders in it can, one at a time: first, second. Known"):
        import_source(tmp_path, model())
    with pytest.raises(NotAFile, match="notes cannot be imported. Known formats: "):
        import_source(tmp_path / "notes", model())


def test_an_unknown_option_lists_the_valid_ones(tmp_path):
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2", motion(), noise())
    with pytest.raises(UnknownKey, match="import of csv: unknown key 'degree'. Valid keys: columns, degrees"):
        import_source(path, model(), degree=True)


def test_an_own_file_is_read_as_it_is(tmp_path):
    signals = {"position": Signal(TIME, motion()), "current": Signal(TIME, noise())}
    write_recording(Recording("run", model(), signals), tmp_path / "run.mcap")
    [found] = import_source(tmp_path / "run.mcap")
    require(found, current=noise())


def test_joints_are_named_one_each(tmp_path):
    path = table(tmp_path / "run.csv", "t,a_q,b_q,a_i,b_i", motion(), noise())
    columns = {"position": "{joint}_q", "current": "{joint}_i"}
    [found] = import_source(path, model(), columns=columns, joints=["b", "a"])
    require(found, position=motion()[:, ::-1])
    for joints in ("a", ["a", "b", "c"]):
        with pytest.raises(ExidynError, match=r"--joints\): \d names, but small has 2 joints"):
            import_source(path, model(), columns=columns, joints=joints)
