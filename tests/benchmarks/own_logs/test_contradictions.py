"""The checker of numbers that a fit gives twice finds none in one fit, and each that is changed."""

import contextlib
import io
import json
import re

import pytest
from parts.own_logs.contradictions import contradictions, in_fit, in_page, in_robot, in_text

from exidyn.acquire.command_line import main
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.small import two_joint_files

CHANGED = ("text", "page", "fit.json", "robot.toml")


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """Text, page and JSON of a fit, and its robot."""
    folder = tmp_path_factory.mktemp("fit")
    write_recording(two_joint_files.run("run"), folder / "run.mcap")
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        assert main(["identify", str(folder / "run.mcap"), "-o", str(folder)]) == 0
        assert (
            main(["export", str(folder / "fit.json"), "--to", "toml", "-o", str(folder / "found.toml")]) == 0
        )
    page = (folder / "report.html").read_text()
    return text.getvalue(), page, json.loads((folder / "fit.json").read_text()), folder / "found.toml"


def said(text, page, fit, robot):
    return [*in_text(text), *in_page(page), *in_fit(fit), *in_robot(read_model(robot), fit)]


def test_one_fit_says_one_thing(outputs):
    found, compared = contradictions(said(*outputs))
    assert found == []
    assert compared > 20


@pytest.mark.parametrize("where", CHANGED)
def test_a_number_that_is_changed_in_one_output_is_found(outputs, where, tmp_path):
    text, page, fit, robot = outputs
    if where == "text":
        text = re.sub(r"(\nFc1 +)\S+", r"\g<1>77.77", text, count=1)
    elif where == "page":
        page = re.sub(r"(<td>Fc1</td><td><data value=\"[^\"]*\">)[^<]*", r"\g<1>77.77", page, count=1)
    elif where == "fit.json":
        base = [{**one, "value": 77.77} if one["name"] == "Fc1" else one for one in fit["base_parameters"]]
        fit = {**fit, "base_parameters": base}
    else:
        changed = re.sub(
            r'(name = "coulomb_friction"\n(?:.*\n)*?values = \[)[^,]*', r"\g<1>77.77", robot.read_text()
        )
        robot = tmp_path / "changed.toml"
        robot.write_text(changed)
    found, _ = contradictions(said(text, page, fit, robot))
    assert [one for one in found if one.startswith("value of Fc1") and "77.77" in one]


FOLDED = """
Verdict
--------------------------------------------------------------------------------
                                        residual /  residual
joint   verdict                              noise       rms     noise
joint1  a little above noise                 1.331  0.006779  0.005094

Parameters
--------------------------------------------------------------------------------
name   value  ± 95 %  unit/(N m/A)  nominal  ± 95 %  note
link inertia
XX2R   1.028   0.078  kg m^2         0.5365   0.047
"""


def test_tables_that_stand_below_one_another_and_words_of_heads_are_told_apart():
    found = {(one.name, one.quantity): one.value for one in in_text(FOLDED)}
    assert found == {
        ("joint1", "over noise"): 1.331,
        ("joint1", "residual"): 0.006779,
        ("joint1", "noise"): 0.005094,
        ("XX2R", "value"): 1.028,
        ("XX2R", "half"): 0.078,
        ("XX2R", "nominal"): 0.5365,
    }
