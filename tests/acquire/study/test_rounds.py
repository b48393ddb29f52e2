"""The folder of a study: a step whose result is there is done, and half a result is none."""

import json
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.study.choice_file import FORMAT
from exidyn.acquire.study.rounds import (
    CHOICE,
    fill_folder,
    forget_end,
    next_round,
    require_same_robot,
    rounds,
)
from exidyn.identification.errors import DifferentRobot, NotAFile

from ...parts.small import two_joints
from ...parts.small.small_choice import choice


def chosen(folder, verdict, number=1, **more):
    one = next_round(folder)
    assert one.number == number
    one.diagnosis.mkdir(parents=True)
    table = choice(verdict) | more
    (one.diagnosis / CHOICE).write_text(json.dumps(table))
    return one


def test_a_folder_appears_when_it_is_whole_and_is_made_once(tmp_path):
    made = []

    def fill(part):
        made.append(part)
        (part / "half").write_text("")
        if len(made) == 1:
            raise KeyboardInterrupt
        assert [path.name for path in part.iterdir()] == ["half"]  # nothing of the first attempt
        (part / "whole").write_text("")

    with pytest.raises(KeyboardInterrupt):
        fill_folder(tmp_path / "fit", fill)
    assert not (tmp_path / "fit").exists()
    fill_folder(tmp_path / "fit", fill)
    fill_folder(tmp_path / "fit", fill)
    assert len(made) == 2
    assert (tmp_path / "fit" / "whole").exists()


def test_a_round_without_a_choice_is_gone_on_with(tmp_path):
    (tmp_path / "round-01").mkdir()
    assert next_round(tmp_path).number == 1


def test_a_round_that_chose_a_run_is_followed_by_another(tmp_path):
    chosen(tmp_path, "run")
    assert next_round(tmp_path).number == 2
    assert [one.number for one in rounds(tmp_path)] == [1]


def test_a_study_that_ended_stays_where_it_is_unless_it_is_asked_otherwise(tmp_path):
    one = chosen(tmp_path, "out of time", asked={"minutes": 5})
    assert next_round(tmp_path).number == 1
    forget_end(tmp_path, {"minutes": 5})
    assert one.choice is not None
    forget_end(tmp_path, {"minutes": 10})
    assert next_round(tmp_path).choice is None


def test_a_choice_of_another_version_is_refused(tmp_path):
    one = chosen(tmp_path, "run", exidyn_study=FORMAT + 1)
    with pytest.raises(NotAFile, match=f"format {FORMAT}"):
        one.choice  # noqa: B018


def test_the_folder_of_another_robot_is_refused(tmp_path):
    model = two_joints.model()
    require_same_robot(tmp_path, model)
    require_same_robot(tmp_path, model)
    other = replace(model, robot=replace(model.robot, drive_gain_tolerance=np.full(2, 0.3)))
    with pytest.raises(DifferentRobot, match="Start in another folder"):
        require_same_robot(tmp_path, other)
