"""Names in files of others are no paths: whatever a command writes stays in the folder it was given."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime

import pytest

from exidyn.acquire.command_line import main
from exidyn.acquire.fleet.source import Source
from exidyn.acquire.fleet.store import Store
from exidyn.acquire.fleet.store_schema import IndexRow
from exidyn.acquire.fleet.work import identify_new, report_path
from exidyn.identification.export import FORMATS
from exidyn.identification.fit.fit_file import write_fit
from exidyn.identification.fleet.kind import kind_key
from exidyn.identification.model import Model
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.robot_files.robot_file import model_text

from ...parts.small.fleet_runs import REFERENCE, START, check_run
from ...parts.small.small_fit import plain_fit
from ...parts.small.two_joint_files import NOMINAL, run
from ...parts.small.two_joints import GAIN

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


def test_pages_and_kinds_of_a_fleet(folder, tmp_path, name):
    store = Store(folder)
    date = datetime(2026, 1, 1, tzinfo=UTC)
    row = IndexRow("key", date, "", "run.mcap", 0, 0.0, "", "", name)
    page = report_path(store, row)
    assert page.resolve().parent.parent == folder / "reports"
    other = IndexRow("key", date, "", "run.mcap", 0, 0.0, "", "", f"{name} ")
    assert report_path(store, other) != page
    recording = check_run({}, GAIN, [REFERENCE, REFERENCE], START)
    key = kind_key(replace(recording, model=renamed(recording.model, name)))
    assert (folder / f"{key}.json").resolve().parent == folder
    store.write_run(row)
    assert all((folder / "runs") in path.parents for path in tmp_path.rglob("*.parquet"))
    assert [row.arm for row in store.index().values()] == [name]


def test_a_fleet_whose_robot_has_a_path_for_a_name(folder, tmp_path, name):
    recording = check_run({}, GAIN, [REFERENCE, REFERENCE], START)
    (folder / "check" / "arm").mkdir(parents=True)
    write_recording(
        replace(recording, model=renamed(recording.model, name)), folder / "check" / "arm" / "run.mcap"
    )
    with ThreadPoolExecutor(1) as executor:
        identify_new(Source("check"), Store(folder / "store"), executor)
    assert all(folder in path.parents for path in outside(folder, tmp_path))
    assert len(list((folder / "store" / "kinds").glob("*.json"))) == 1
