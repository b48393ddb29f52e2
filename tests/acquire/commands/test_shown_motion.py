"""exidyn excite --show: what it prints, writes and refuses."""

import re
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.views.live_view import Targets
from exidyn.identification.robot_files.robot_file import model_text, urdf_text
from exidyn.trajectories.plans.exports import EXPORTS
from exidyn.trajectories.plans.plan_file import write_plan
from exidyn.trajectories.plans.plan_page import plan_page

from ...parts.plans.plans import fourier, known_plan
from ...parts.small import two_joints

MOTION = fourier().scaled(0.5)
"""Within all limits of the arm."""


@pytest.fixture
def folder(tmp_path):
    """A folder with plan.toml, beyond.toml, robot.toml and slower.toml."""
    write_plan(known_plan(MOTION), tmp_path / "plan.toml")
    write_plan(known_plan(fourier().scaled(4.0)), tmp_path / "beyond.toml")
    model = two_joints.model()
    (tmp_path / "robot.toml").write_text(model_text(model))
    slower = replace(model.robot, limits=replace(model.robot.limits, velocity=np.array([2.0, 3.0])))
    (tmp_path / "slower.toml").write_text(model_text(replace(model, robot=slower)))
    return tmp_path


def show(folder, plan, *arguments, robot=""):
    robots = [str(folder / robot) if robot.endswith(".toml") else robot] if robot else []
    return main(["excite", *robots, "--show", str(folder / plan), *arguments])


def test_summary_is_printed_and_the_page_written(folder, capsys):
    assert show(folder, "plan.toml") == 0
    printed, text = capsys.readouterr()
    assert "Motion for two joints: 6.66667 s, fourier" in printed
    assert "BEYOND" not in printed
    assert "torque\n" not in printed.replace(" ", "")
    assert text == f"written: {folder / 'plan.html'}\n"
    assert (folder / "plan.html").read_text(encoding="utf-8") == plan_page(known_plan(MOTION))


def test_a_plan_beyond_its_limits_is_reported(folder, capsys):
    assert show(folder, "beyond.toml", "--output", str(folder / "other.html")) == 0
    assert "BEYOND: shoulder: velocity at" in capsys.readouterr().out
    assert "Exceeds limits: do not run it." in (folder / "other.html").read_text(encoding="utf-8")
    assert not (folder / "beyond.html").exists()


def test_with_the_robot_torque_is_shown(folder, capsys):
    assert show(folder, "plan.toml", robot="robot.toml") == 0
    printed, text = capsys.readouterr()
    assert "torque\n" in printed.replace(" ", "")  # the head is folded: % is below
    assert "warning" not in text
    assert "torque [N m]" in (folder / "plan.html").read_text(encoding="utf-8")


def test_another_robot_is_warned_of_or_refused(folder, capsys):
    assert show(folder, "plan.toml", robot="slower.toml") == 0
    text = capsys.readouterr().err
    assert "warning: limit velocity of shoulder is 2; it was 3 when the plan was made" in text
    assert show(folder, "plan.toml", robot="kr270") == REFUSED
    text = capsys.readouterr().err
    assert "the plan is for the joints shoulder, elbow of two joints; kr270 has joint1, joint2" in text


@pytest.mark.parametrize("name", EXPORTS)
def test_points_are_written_in_place_of_the_page(folder, capsys, name):
    assert show(folder, "plan.toml", "--to", name, "-o", str(folder / "out"), "--rate", "10") == 0
    assert (folder / "out").read_text(encoding="utf-8") == EXPORTS[name](known_plan(MOTION), 10.0)
    assert str(folder / "out") in capsys.readouterr().err
    assert not (folder / "plan.html").exists()
    assert show(folder, "plan.toml", "--to", name) == 0
    assert (folder / f"plan.{name}").exists()


def test_a_view_can_be_saved(folder, capsys):
    assert show(folder, "plan.toml", "--save", str(folder / "plan.rrd"), robot="robot.toml") == 0
    assert (folder / "plan.rrd").stat().st_size > 10_000
    assert str(folder / "plan.rrd") in capsys.readouterr().err


def test_a_view_can_be_opened(folder, monkeypatch):
    opened = []
    monkeypatch.setattr(
        "exidyn.acquire.views.viewers.show", lambda view, targets: opened.append((view.kind, targets))
    )
    assert show(folder, "plan.toml", "--view", robot="robot.toml") == 0
    assert opened == [("plan", Targets(view=True))]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--view"], "give ROBOT"),
        (["--save", "x.rrd"], "give ROBOT"),
        (["--rate", "0"], "0 must be above 0"),
        (["--rate", "nan"], "nan must be above 0"),
        (["--to", "xml"], "invalid choice: 'xml'"),
        (["--length", "3"], "--show and --length cannot be used together"),
    ],
)
def test_wrong_options_state_what_is_wrong(folder, arguments, words, capsys):
    with pytest.raises(SystemExit) as stopped:
        show(folder, "plan.toml", *arguments)
    assert stopped.value.code == REFUSED
    assert words in capsys.readouterr().err


def test_what_is_no_plan_is_refused(folder, capsys):
    assert show(folder, "robot.toml") == REFUSED
    assert f"{folder / 'robot.toml'}: not a trajectory file: no key 'kind'" in capsys.readouterr().err


def test_help_explains_each_format(capsys):
    with pytest.raises(SystemExit):
        main(["excite", "--help"])
    printed = " ".join(capsys.readouterr().out.split())
    for name, function in EXPORTS.items():
        assert f" {name} {function.__doc__.splitlines()[0]}" in printed


CELL = """
[[obstacle]]
name = "crate"
box = [0.2, 0.2, 0.2]
at = [{x}, 0.0, 0.0]

[[region]]
point = "flange"
upper = [inf, inf, 2.0]
"""


def with_cell(folder, x):
    """A robot file of the arm with bodies, and a crate around a place on the x axis."""
    text = urdf_text(two_joints.model()).replace("visual>", "collision>")
    (folder / "bodies.urdf").write_text(text)
    limits = "[limits]\nacceleration = 20.0\njerk = 400.0\n"
    (folder / "bodies.toml").write_text(f'urdf = "bodies.urdf"\n{limits}{CELL.format(x=x)}')


def test_what_a_motion_comes_nearest_to_is_stated_and_drawn(folder):
    with_cell(folder, 3.0)
    assert show(folder, "plan.toml", robot="bodies.toml") == 0
    page = (folder / "plan.html").read_text(encoding="utf-8")
    assert re.search(r"Nearest: link2_1 to crate \d{4} mm at .* s; flange z &lt;= 2 m \d{4} mm", page)
    assert ">crate</text>" in page
    assert "Not checked here: torque of" in page  # and no collisions


def test_a_motion_through_an_obstacle_is_beyond(folder, capsys):
    with_cell(folder, 0.6)
    assert show(folder, "plan.toml", robot="bodies.toml") == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert re.search(r"BEYOND: .*link\d_\d to crate: -\d+ mm at \d", printed)
    assert show(folder, "plan.toml", "--no-collision", robot="bodies.toml") == 0
    assert "BEYOND" not in capsys.readouterr().out


def test_limits_raised_by_hand_are_reported_and_percentages_are_of_the_robot(folder, capsys):
    plan = known_plan(MOTION)
    assert show(folder, "plan.toml", robot="robot.toml") == 0
    honest = capsys.readouterr().out
    raised = replace(plan.limits, velocity=50.0 * plan.limits.velocity, torque=50.0 * plan.limits.torque)
    write_plan(replace(plan, limits=raised, edited=True), folder / "plan.toml")
    assert show(folder, "plan.toml", robot="robot.toml") == 0
    printed, text = capsys.readouterr()
    assert printed == honest
    assert "warning: the plan's file has no checksum" in text
    assert "warning: limits in the plan's file exceed those of two joints, which are used: velocity" in text
