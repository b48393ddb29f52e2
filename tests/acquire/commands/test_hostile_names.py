"""Names in files of others are no paths: whatever a command writes stays in the folder it was given."""

from dataclasses import replace

import pytest

from exidyn.acquire.command_line import main
from exidyn.identification.export import FORMATS
from exidyn.identification.fit.fit_file import write_fit
from exidyn.identification.model import Model
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.robot_files.robot_file import model_text

from ...parts.small.small_fit import plain_fit
from ...parts.small.two_joint_files import NOMINAL, run

NAMES = ["../../../PWNED", "{outside}/PWNED", "..", "a/b/../../c", "NUL"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Four folders deep, so that three steps up are still in `tmp_path`."""
    inside = tmp_path / "a" / "b" / "c" / "d"
    inside.mkdir(parents=True)
    monkeypatch.chdir(inside)
    return inside


@pytest.fixture(params=NAMES)
def name(request, tmp_path):
    return request.param.format(outside=tmp_path)


def renamed(model: Model, name: str) -> Model:
    return replace(model, robot=replace(model.robot, name=name))


def outside(folder, tmp_path):
    """Files that lie elsewhere than in the folder."""
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    return [path for path in files if path.parent != folder]


@pytest.mark.parametrize("form", FORMATS)
def test_export_of_a_robot_file(folder, tmp_path, name, form):
    (folder / "arm.toml").write_text(model_text(renamed(NOMINAL, name)))
    assert main(["export", "arm.toml", "--to", form]) == 0
    assert not outside(folder, tmp_path)
    assert len(list(folder.glob("*-export.*"))) == 1


def test_export_of_a_fit_and_of_a_recording(folder, tmp_path, name):
    write_fit(replace(plain_fit(), model=renamed(plain_fit().model, name)), folder / "fit.json")
    write_recording(replace(run("run"), model=renamed(NOMINAL, name), name=name), folder / "run.mcap")
    for source, form in (("fit.json", "toml"), ("run.mcap", "urdf"), ("run.mcap", "csv")):
        assert main(["export", source, "--to", form]) == 0
    assert not outside(folder, tmp_path)


def test_import_of_recordings(folder, tmp_path, name):
    write_recording(replace(run("run"), name=name), folder / "source.mcap")
    (folder / "new").mkdir()
    assert main(["import", "source.mcap", "-o", "new"]) == 0
    assert not outside(folder / "new", tmp_path) or outside(folder / "new", tmp_path) == [
        folder / "source.mcap"
    ]
    assert len(list((folder / "new").glob("*.mcap"))) == 1
