"""The command `exidyn`, in this process."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exidyn.acquire import command_line
from exidyn.acquire.command_line import COMMANDS, INTERRUPTED, REFUSED, main
from exidyn.identification.fit.estimators import ESTIMATORS
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.recordings.tables.columns import PREFIXES
from exidyn.identification.robot_files.robot_file import model_text

from ...parts.small import two_joints
from ...parts.small.two_joint_files import loaded, run, write

pytestmark = pytest.mark.slow

DOCS = Path(__file__).parents[3] / "docs"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Paths of runs: empty, loaded (silent about its payload), other."""
    folder = tmp_path_factory.mktemp("runs")
    return write(folder, run("empty"), loaded(), run("other", 2, 3))


@pytest.fixture
def fit_of(tmp_path):
    """A function that identifies by the command line, into a folder to be made, and reads the fit."""

    def run(*arguments):
        assert main(["identify", *arguments, "--output", str(tmp_path / "out")]) == 0
        return read_fit(tmp_path / "out" / "fit.json")

    return run


def test_a_payload_of_known_mass_identifies_the_drive_gains(files, fit_of, tmp_path, capsys):
    empty, full, other = files
    fit = fit_of(empty, "--payload", full, "--mass", "3", "--validate", other, "--full")
    printed, progress = capsys.readouterr()
    assert "Identified dynamics of two joints" in printed
    assert "Validated on:     other" in printed
    assert max(map(len, printed.splitlines())) <= 110
    assert "estimate" in progress
    assert "report.html" in progress
    assert fit.runs == ("empty", "loaded")
    error = np.abs(fit.estimate.gain - two_joints.GAIN)
    assert np.all(error < 4 * fit.estimate.gain_std)
    assert np.all(error < 0.01 * np.abs(two_joints.GAIN))
    assert (tmp_path / "out" / "report.html").stat().st_size > 10_000


def test_options_arrive_and_json_is_the_fit_and_nothing_else(files, fit_of, tmp_path, capsys):
    options = "--position-cutoff 9 --torque-cutoff 6 --standstill 0.02 --estimator weighted --json -".split()
    fit = fit_of(files[0], *options, "--save", str(tmp_path / "fit.rrd"))
    printed = capsys.readouterr().out
    assert json.loads(printed)["joints"] == ["shoulder", "elbow"]
    assert printed.strip() == (tmp_path / "out" / "fit.json").read_text().strip()
    assert replace(fit.filtering, rate=None) == Filtering(None, 9.0, 6.0, 0.02)
    assert "weighted" in fit.estimate.method
    assert (tmp_path / "fit.rrd").stat().st_size > 1000


def test_two_bodies_have_two_names_and_one_body_one(files, fit_of):
    empty, full, other = files
    pair = [empty, "--payload", full, "--mass", "3", "--payload"]
    assert {"MXL", "MXL2"} <= set(fit_of(*pair, other, "--mass", "1e-3").model.names)
    assert {"MXL", "MXL2"} & set(fit_of(*pair, full, "--mass", "3").model.names) == {"MXL"}


def test_the_payload_inside_a_file_counts(files, fit_of, tmp_path):
    [path] = write(tmp_path, loaded(KnownPayload("weight", two_joints.MASS)))
    fit = fit_of(files[0], "--payload", path)
    assert "MXweight" in fit.model.names
    assert np.all(fit.estimate.gain_std > 0)


def test_center_of_mass_and_inertia_are_known_then(files, fit_of):
    body = ["--mass", "3", "--com", "0.1", "0", "-.05", "--inertia", *"1 0 0 1 0 1".split()]
    names = fit_of(files[0], "--payload", files[1], *body).model.names
    assert not [name for name in names if name.endswith("L")]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--mass", "3"], "--mass must follow the --payload"),
        (["--payload", "RUN", "--mass", "3", "--mass", "4"], "has --mass twice"),
        (["--torque-cutoff", "0"], "must be above 0"),
        (["--estimator", "magic"], "invalid choice: 'magic'"),
    ],
)
def test_wrong_options_state_what_is_wrong(files, options, words, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["identify", files[0], *options])
    assert stopped.value.code == REFUSED
    assert words in capsys.readouterr().err


def test_info_prints_what_is_inside(files, tmp_path, capsys):
    [path] = write(tmp_path, loaded(KnownPayload("weight", two_joints.MASS)))
    assert main(["info", path, "--full"]) == 0
    printed = capsys.readouterr().out
    model = "link_inertia, viscous_friction, coulomb_friction, current_offset"
    for words in ("two joints: shoulder, elbow", model, "weight: M 3.000", "position  rad", "5000  250.0"):
        assert words in printed


def test_import_writes_recordings_and_reports_it(tmp_path, capsys):
    recording = run("table")
    signals = {name: recording.signals[name] for name in ("position", "current")}
    columns = np.column_stack([signals["position"].time, *(s.values for s in signals.values())])
    table, robot = tmp_path / "table.csv", tmp_path / "robot.toml"
    columns[:, 1:3] = np.degrees(columns[:, 1:3])
    np.savetxt(table, columns, "%.17g", ",", header="zeit,shoulder_ist,elbow_ist,a,b", comments="")
    robot.write_text(model_text(recording.model))
    columns = ["--columns", "time=zeit", "position={joint}_ist", "current=a,b"]
    options = ["--robot", str(robot), "--degrees", *columns]
    assert main(["import", str(table), *options, "--output", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "out/table.mcap: two joints, 19.996 s, position 250.0 Hz, current 250.0 Hz" in printed
    found = read_recording(tmp_path / "out" / "table.mcap").signals
    np.testing.assert_allclose(found["position"].values, signals["position"].values, atol=1e-12)
    assert np.array_equal(found["current"].values, signals["current"].values)


@pytest.mark.parametrize(("signals", "turned"), [(["torque"], {"torque"}), ([], {"torque", "position"})])
def test_motor_side_takes_the_signals_named_or_all(tmp_path, signals, turned):
    robot = replace(run("table").robot, gear_ratio=np.array([100.0, 50.0]))
    (tmp_path / "robot.toml").write_text(model_text(replace(run("table").model, robot=robot)))
    (tmp_path / "run.csv").write_text("t,q1,q2,tau1,tau2\n0,.5,-1,.1,-.2\n.1,.4,-1,.2,-.2\n.2,.3,-1,.3,-.2\n")
    given = [str(tmp_path / "run.csv"), "--robot", str(tmp_path / "robot.toml"), "--output", str(tmp_path)]
    assert main(["import", *given, "--motor-side", *signals]) == 0
    found = read_recording(tmp_path / "run.mcap").signals
    torque, position = found["torque"].values[0], found["position"].values[0]
    np.testing.assert_allclose(torque, [10.0, -10.0])
    np.testing.assert_allclose(position, [0.005, -0.02] if "position" in turned else [0.5, -1.0])


def test_motor_side_of_currents_is_refused(capsys):
    with pytest.raises(SystemExit):
        main(["import", "run.csv", "--motor-side", "current"])
    assert "'current'" in capsys.readouterr().err


def test_columns_are_explained_by_the_command_and_the_page(capsys):
    with pytest.raises(SystemExit):
        main(["import", "--help"])
    text, page = capsys.readouterr().out, (DOCS / "import.md").read_text()
    for first in (prefixes[0] for prefixes in PREFIXES.values()):
        assert f"  {first}1" in text
        assert f"`{first}1`" in page


def test_the_table_of_the_page_can_be_pasted(tmp_path):
    (tmp_path / "run.csv").write_text((DOCS / "import.md").read_text().split("```")[1].removeprefix("csv\n"))
    (tmp_path / "robot.toml").write_text(model_text(run("table").model))
    given = [str(tmp_path / "run.csv"), "--robot", str(tmp_path / "robot.toml"), "--output", str(tmp_path)]
    assert main(["import", *given]) == 0
    assert len(read_recording(tmp_path / "run.mcap").signals["current"]) == 4


def test_import_prints_the_rate_of_all_samples_where_many_are_missing(tmp_path, capsys):
    recording = run("holes")
    kept = np.flatnonzero(np.arange(5000) % 5)
    thinned = {name: signal[kept] for name, signal in recording.signals.items()}
    [path] = write(tmp_path, replace(recording, signals=thinned))
    assert main(["import", path, "--output", str(tmp_path / "out")]) == 0
    assert "position 200.0 Hz" in capsys.readouterr().out


def test_help_lists_the_commands_and_so_does_no_command(capsys):
    assert main([]) == 0
    without = capsys.readouterr().out
    for arguments in (["--help"], ["--version"]):
        with pytest.raises(SystemExit) as stopped:
            main(arguments)
        assert stopped.value.code == 0
    assert capsys.readouterr().out.startswith(without)
    assert all(f"  {name} " in without for name in COMMANDS)


def test_each_estimator_is_explained(capsys):
    with pytest.raises(SystemExit):
        main(["identify", "--help"])
    printed = " ".join(capsys.readouterr().out.split())
    for name, function in ESTIMATORS.items():
        assert f" {name} {function.__doc__.splitlines()[0]} " in printed


def test_help_does_not_load_the_libraries():
    program = "import sys, exidyn.acquire.command_line; print({'pinocchio', 'numpy'} & set(sys.modules))"
    assert subprocess.check_output([sys.executable, "-c", program], text=True).strip() == "set()"


def test_an_interruption_ends_quietly(monkeypatch, capsys):
    def interrupted(name, arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(command_line, "run_command", interrupted)
    assert main(["info", "run.mcap"]) == INTERRUPTED
    assert capsys.readouterr().err == "exidyn: interrupted\n"


def test_a_folder_that_cannot_be_written_is_named(files, tmp_path, capsys):
    (tmp_path / "taken").write_text("")
    assert main(["identify", files[0], "--output", str(tmp_path / "taken")]) == REFUSED
    text = capsys.readouterr().err
    assert text == f"exidyn: {tmp_path / 'taken'}: this file exists; --output needs a folder\n"
    assert main(["identify", files[0], "--output", str(tmp_path / "taken" / "below")]) == REFUSED
    assert f"{tmp_path / 'taken' / 'below'}: --output cannot be written: " in capsys.readouterr().err


def test_only_validation_runs_are_identified_from(fit_of, tmp_path):
    path = write(tmp_path, replace(run("alone"), settings={"role": "validate"}))
    assert fit_of(*path).runs == ("alone",)


def test_shapes_are_fitted_where_asked(files, fit_of, tmp_path, capsys):
    fit_of(files[0], "--shapes", "coulomb_friction", "--full")
    page = capsys.readouterr().out
    found = [float(value) for value in re.findall(r"coulomb friction \(\w+\): reversal (\S+) rad/s", page)]
    assert len(found) == 2
    # 0.003 rad/s passes in a millisecond of these motions: little more is known than that it is small
    assert all(1e-4 <= value < 0.02 for value in found)
    assert main(["identify", files[0], "--output", str(tmp_path), "--shapes", "stribeck_friction"]) == REFUSED
    assert "stribeck_friction" in capsys.readouterr().err
