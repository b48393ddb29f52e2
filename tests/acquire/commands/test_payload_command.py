"""exidyn payload: page, JSON, forms of controllers, plan, and options that exclude each other."""

import json
from dataclasses import replace

import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.commands.payload_command import _beyond_plan
from exidyn.identification.payload.formats import FORMATS
from exidyn.identification.robot_files.robot_text import model_text
from exidyn.trajectories.planning.payload_motion import HEAVIEST
from exidyn.trajectories.plans.plan_file import plan_text, read_plan

from ...parts.plans.plans import known_plan
from ...parts.small.two_joint_files import NOMINAL, loaded, run, write

CENTER = ["0.1", "0", "0.05"]


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> list[str]:
    """Runs without and with 3 kg, of which the files are silent; stated drive gains are 10 % too high."""
    return write(tmp_path_factory.mktemp("runs"), run("empty"), loaded())


def test_the_difference_of_two_runs(files, tmp_path, capsys) -> None:
    empty, full = files
    table = tmp_path / "payload.json"
    options = ["--empty", empty, "--com", *CENTER, "--for", "ur", "mjcf", "--json", str(table)]
    assert main(["payload", full, *options, "--as-recorded"]) == 0
    page = capsys.readouterr().out
    assert "Payload of two joints" in page
    assert "set_target_payload(" in page
    assert "<inertial" in page
    found = json.loads(table.read_text())
    assert found["mass"]["low"] < 3.0 < found["mass"]["high"]
    assert found["arm_known_from"] == "difference"
    assert set(found["forms"]) == {"ur", "mjcf"}
    assert found["frame"] == "[flange]"


def test_json_on_standard_output_has_all_forms(files, capsys) -> None:
    assert main(["payload", files[1], "--com", *CENTER, "--as-recorded", "--json", "-"]) == 0
    assert set(json.loads(capsys.readouterr().out)["forms"]) == set(FORMATS)


@pytest.fixture
def plan_for(tmp_path, capsys):
    """The command that plans a motion of the two-joint arm: its exit code and what it prints."""
    (tmp_path / "robot.toml").write_text(model_text(NOMINAL))

    def run(*options):
        paths = ["--robot", str(tmp_path / "robot.toml"), "-o", str(tmp_path / "weigh.toml")]
        code = main(["payload", *paths, "--up-to", "4", "--no-collision", "--search", "0.1", *options])
        printed = capsys.readouterr()
        return code, " ".join((printed.out + printed.err).split())

    return run


def test_a_plan_of_poses(plan_for, tmp_path) -> None:
    code, printed = plan_for("--reach", "0.1", "--kind", "poses")
    assert code == 0
    assert "any up to 4 kg" in printed
    plan = read_plan(tmp_path / "weigh.toml")
    assert (plan.robot, plan.details[HEAVIEST]) == ("two joints", 4.0)


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--length", "6", "--search", "0.001"], 0, "would not determine the payload"),  # its start
        (["--length", "1"], REFUSED, "length: 1 s; the shortest possible is "),
        (["--start", "0", "0", "0"], REFUSED, "--start: 3 values; give 1 or 2, one per joint"),
        (["--up-to", "5000"], REFUSED, "payload of up to 5000 kg within 0.2 m of the flange"),
    ],
)
def test_a_poor_motion_is_called_poor_and_none_is_refused(plan_for, options, code, words) -> None:
    ended, printed = plan_for(*options)
    assert ended == code
    assert words in printed


def test_a_payload_above_what_the_motion_allows_is_warned_about() -> None:
    planned, other = (
        plan_text(replace(known_plan(), details=details)) for details in ({HEAVIEST: 5.0}, {"kind": "sweep"})
    )
    assert _beyond_plan(4.9, [planned, other]) == []
    assert _beyond_plan(9.0, [other]) == []
    [warning] = _beyond_plan(5.1, [other, planned])
    assert "heavier than the 5 kg for which the motion was planned" in warning


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("", "give a run with the payload"),
        ("--up-to 3", "--up-to needs the arm as --robot or --fit"),
        ("run.mcap --up-to 3 --robot cobot", "--up-to and runs cannot be used together"),
        ("run.mcap --fit f.json --empty e.mcap", "--fit and --empty cannot be used together"),
        ("run.mcap --fit f.json --robot cobot", "--fit and --robot cannot be used together"),
        ("run.mcap --fit f.json --kind poses", "--kind is only used with --up-to KG"),
        ("--up-to 3 --robot cobot --for ur", "--up-to and --for cannot be used together"),
        ("--up-to 3 --robot cobot --kind poses --length 9", "--kind poses and --length cannot be used"),
    ],
)
def test_options_that_exclude_each_other(options, words, capsys) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["payload", *options.split()])
    assert ended.value.code == REFUSED
    assert words in capsys.readouterr().err
