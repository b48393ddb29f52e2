"""What people give by mistake: each one clear error or warning at the command line."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.robot_files.robot_file import model_text

from ...parts.runs.parser_files import write_two_traces
from ...parts.small.two_joint_files import loaded, of_another_arm, run, write

pytestmark = pytest.mark.slow

RUN = run("run")
Change = Callable[[np.ndarray, np.ndarray, np.ndarray], tuple]


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(arguments: list[str], capsys) -> str:
    """The one line that the command prints before it ends."""
    assert main(arguments) == REFUSED
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("exidyn: ")]
    assert len(lines) == 1
    return lines[0]


def table(
    folder: Path, change: Change = lambda t, q, i: (t, q, i), header: str = "t,q1,q2,i1,i2"
) -> list[str]:
    """Arguments that import a table of the run, changed."""
    signals = RUN.signals
    columns = change(
        signals["position"].time.copy(), signals["position"].values.copy(), signals["current"].values.copy()
    )
    np.savetxt(folder / "run.csv", np.column_stack(columns), "%.9g", ",", header=header, comments="")
    (folder / "robot.toml").write_text(model_text(RUN.model))
    return ["import", "run.csv", "--robot", "robot.toml"]


def with_current(current: np.ndarray) -> Recording:
    signals = {**RUN.signals, "current": Signal(RUN.signals["current"].time, current)}
    return replace(RUN, signals=signals)


def at(rows, columns, value):
    """A change that puts a value into positions."""

    def change(t, q, i):
        q[rows, columns] = value
        return t, q, i

    return change


def steps_back(t, q, i):
    t[200] -= 1.0
    return t, q, i


@pytest.mark.parametrize(
    ("change", "header", "words"),
    [
        (lambda t, q, i: (t, q, i), "x,q1,q2,i1,i2", "name it by exidyn import --columns time=NAME"),
        (lambda t, q, i: (t, q, i), "t,a,b,i1,i2", "by exidyn import --columns position=NAME,NAME"),
        (lambda t, q, i: (t, np.degrees(q), i), "t,q1,q2,i1,i2", "exidyn import --degrees"),
        (lambda t, q, i: (1000 * t, q, i), "t,q1,q2,i1,i2", "exidyn import --units time=ms"),
        (at(slice(100, 103), 1, 1e20), "t,q1,q2,i1,i2", "run.csv line 102: run: position of elbow"),
        (lambda t, q, i: (t, q + [90, 0], i), "t,q1,q2,i1,i2", "shoulder is at"),
        (steps_back, "t,q1,q2,i1,i2", "at 1 of 4999 steps, first from 0.796"),
    ],
    ids=["time", "position", "degrees", "milliseconds", "huge", "90 rad", "time step"],
)
def test_what_is_wrong_with_a_table_is_said_with_the_option(folder, change, header, words, capsys):
    assert words in refused(table(folder, change, header), capsys)


def test_a_table_without_robot_asks_for_the_option(folder, capsys):
    assert "--robot FILE" in refused(table(folder)[:2], capsys)


def test_gaps_are_warned_of_and_imported(folder, capsys):
    assert (
        main(table(folder, lambda t, q, i: [np.delete(a, slice(2000, 2125), axis=0) for a in (t, q, i)])) == 0
    )
    printed, warned = capsys.readouterr()
    assert "warning: position, current: 1 gap of more than 1.5 median periods of 4.000 ms" in warned
    assert "run.mcap: two joints" in printed


def test_saturated_currents_give_a_warning_in_the_summary(folder, capsys):
    current = RUN.signals["current"].values.copy()
    limit = 0.6 * np.abs(current[:, 0]).max()
    current[:, 0] = np.clip(current[:, 0], -limit, limit)
    [path] = write(folder, with_current(current))
    assert main(["identify", path]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "run: current: shoulder is at exactly" in printed
    assert "it is clipped there" in printed


def test_a_constant_current_is_refused_with_the_joint(folder, capsys):
    current = RUN.signals["current"].values.copy()
    current[:, 1] = 0.25
    [path] = write(folder, with_current(current))
    text = refused(["identify", path], capsys)
    assert "elbow is constant at 0.25" in text


def test_a_motion_too_poor_is_refused_or_warned_of(folder, capsys):
    position = RUN.signals["position"]
    still = Signal(position.time, position.values * [0.0, 1.0])
    [path] = write(folder, replace(RUN, signals={**RUN.signals, "position": still}))
    text = refused(["identify", path], capsys)
    assert "shoulder" in text or "joint 1" in text
    [path] = write(folder, run("nearly", reach=(1.0, 0.01)))
    assert main(["identify", path]) == 0
    assert "- elbow moves by only" in capsys.readouterr().out


def test_gains_need_a_payload_of_known_mass(folder, capsys):
    [path] = write(folder, RUN)
    text = refused(["identify", path, "--estimator", "ml"], capsys)
    assert "give --payload RUN --mass KG" in text
    unknown = replace(RUN.robot, drive_gain=np.ones(2))
    runs = [replace(run, model=replace(run.model, robot=unknown)) for run in (RUN, loaded())]
    empty, full = write(folder, *runs)
    text = refused(["identify", empty, "--payload", full], capsys)
    assert "its mass is unknown" in text
    assert "Add --mass KG after this --payload, or state the drive gains" in text
    text = refused(["identify", empty, "--payload", full, "--com", "0", "0", "0.1"], capsys)
    assert "com given without --mass" in text
    [silent] = write(folder, replace(runs[1], payload=KnownPayload("L")))
    assert "Add --mass KG" in refused(["identify", empty, "--payload", silent], capsys)
    empty, full = write(folder, RUN, loaded())
    assert main(["identify", empty, "--payload", full, "--full"]) == 0
    assert "payload L" in capsys.readouterr().out


def test_what_does_not_exist_or_is_another_robot_is_named(folder, capsys):
    paths = write(folder, RUN, of_another_arm(run("far")))
    assert "run was recorded on two joints" in refused(["identify", *paths], capsys)
    assert "with --robot" in refused(["identify", paths[0], "--validate", paths[1]], capsys)
    assert f"nothing.mcap does not exist; looked in {Path.cwd()}" in refused(
        ["identify", "nothing.mcap"], capsys
    )
    assert "Built-in robots: cobot, kr270" in refused(["identify", "run.mcap", "--robot", "ur5"], capsys)


def test_a_truncated_recording_is_read_with_a_warning(folder, capsys):
    [path] = write(folder, RUN)
    whole = Path(path).read_bytes()
    Path(path).write_bytes(whole[: int(0.8 * len(whole))])
    assert main(["identify", path]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "run: file ends abruptly: the run is known up to" in printed
    assert main(["info", path]) == 0
    assert "warning: file ends abruptly" in capsys.readouterr().out


def test_an_output_with_the_ending_of_a_recording_is_a_file(folder, capsys):
    assert main([*table(folder), "-o", "one.mcap"]) == 0
    assert (folder / "one.mcap").is_file()
    assert "one.mcap: two joints" in capsys.readouterr().out
    assert main(["info", "one.mcap"]) == 0


def test_several_runs_in_one_file_are_refused(folder, capsys):
    write_two_traces(folder / "traces")
    (folder / "robot.toml").write_text(model_text(RUN.model))
    text = refused(["import", "traces", "--robot", "robot.toml", "-o", "one.mcap"], capsys)
    assert text.startswith("exidyn: traces contains 2 runs (again, run), but --output one.mcap is one ")
    assert text.endswith("Name a folder: --output one")
    assert not (folder / "one.mcap").exists()
