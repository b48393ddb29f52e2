"""LeRobot data sets of both layouts: a file an episode (version 2), several in a file (version 3)."""

import json
from pathlib import Path

import numpy as np
import pytest

from exidyn.identification.errors import NotAFile, RecordingError, WrongShape
from exidyn.identification.recordings.importers import import_source, kind_of

from ...parts.runs.runs import model, motion, noise, require

pytestmark = pytest.mark.usefixtures("in_process")

FPS = 250
LEFT, RIGHT = (["left_axis1", "left_axis2"], ["right_axis1", "right_axis2"])


def write_data_set(folder: Path, names, joints: int = 2, version: int = 2) -> Path:
    """Two episodes; `names` are those of the joints, in the form of one version or another."""
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    episodes = []
    for episode in (0, 1):
        values = {"observation.state": motion(joints), "observation.effort": noise(joints, episode)}
        values |= {"action": motion(joints) + episode}
        count = len(motion())
        vector = arrow.list_(arrow.float32(), joints)
        columns = {name: arrow.array(list(array.astype("f4")), vector) for name, array in values.items()}
        columns["timestamp"] = arrow.array((np.arange(count) / FPS).astype("f4"))
        columns["frame_index"] = arrow.array(np.arange(count))
        columns["episode_index"] = arrow.array([episode] * count)
        columns["task"] = arrow.array(["lift"] * count)
        episodes.append(arrow.table(columns))
    chunk = folder / "data" / "chunk-000"
    chunk.mkdir(parents=True)
    if version == 3:
        parquet.write_table(arrow.concat_tables(episodes), chunk / "file-000.parquet")
    else:
        for number, table in enumerate(episodes):
            parquet.write_table(table, chunk / f"episode_{number:06d}.parquet")
    (folder / "meta").mkdir()
    state = {"dtype": "float32", "shape": [joints], "names": names}
    info = {"codebase_version": f"v{version}.0", "fps": FPS, "features": {"observation.state": state}}
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    return folder


@pytest.mark.parametrize(("names", "version"), [(["pan", "lift"], 2), ({"motors": ["axis1", "axis2"]}, 3)])
def test_episodes_are_runs(tmp_path, names, version):
    folder = write_data_set(tmp_path / "lift", names, version=version)
    assert kind_of(folder) == "lerobot"
    runs = import_source(folder, model())
    assert [run.name for run in runs] == ["lift/episode_000000", "lift/episode_000001"]
    for episode, run in enumerate(runs):
        expected = {"position": motion(), "torque": noise(2, episode), "command": motion() + episode}
        assert set(run.signals) == set(expected)
        for signal, values in expected.items():
            assert np.array_equal(run.signals[signal].values, values.astype("f4"))
        # Not rounded to single precision, as the data set's own time stamps are.
        time = np.rint(np.arange(200) / FPS * 1e9) / 1e9
        require(run, time=time)


def test_effort_may_be_current(tmp_path):
    run = import_source(write_data_set(tmp_path / "lift", None), model(), effort="current")[0]
    require(run, current=noise(2, 0).astype("f4"))


@pytest.mark.parametrize("names", [[f"{name}.pos" for name in LEFT + RIGHT], [LEFT + RIGHT]])
def test_one_arm_of_two_is_chosen_by_its_joints(tmp_path, names):
    folder = write_data_set(tmp_path / "fold", names, joints=4)
    with pytest.raises(RecordingError, match=r"of 2 arms; choose one by --joints 'left_\{joint\}', --"):
        import_source(folder, model())
    run = import_source(folder, model(), joints="right_{joint}")[0]
    require(run, position=motion(4)[:, 2:].astype("f4"))
    crossed = import_source(folder, model(), joints=["right_axis2", "left_axis1"])[0]
    require(crossed, torque=noise(4, 0)[:, [3, 0]].astype("f4"))


def test_joints_that_are_not_there_are_listed(tmp_path):
    folder = write_data_set(tmp_path / "fold", ["waist", "elbow", "gripper"], joints=3)
    with pytest.raises(RecordingError, match="no joint 'axis1'. Valid joints: waist, elbow, gripper; name"):
        import_source(folder, model())
    run = import_source(folder, model(), joints=["elbow", "waist"])[0]
    require(run, position=motion(3)[:, 1::-1].astype("f4"))
    unnamed = write_data_set(tmp_path / "unnamed", None, joints=3)
    with pytest.raises(WrongShape, match="observation.state has 3 columns for 2 joints"):
        import_source(unnamed, model())


@pytest.mark.parametrize(
    ("info", "message"),
    [
        ("{", "does not describe a LeRobot data set"),
        ('{"fps": 0, "features": {"observation.state": {}}}', "fps is 0.0"),
        ('{"fps": 30, "features": {}}', "'observation.state'"),
        ('{"fps": 30, "features": {"observation.state": {}}}', "has no episodes in data/"),
    ],
)
def test_what_is_no_data_set_is_refused(tmp_path, info, message):
    (tmp_path / "meta").mkdir()
    (tmp_path / "meta" / "info.json").write_text(info)
    with pytest.raises(NotAFile, match=message):
        import_source(tmp_path, model())
