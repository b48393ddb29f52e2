"""A choice that a person edited is read or refused in one line."""

import json

import pytest
from msgspec.structs import replace

from exidyn.acquire.study.choice_file import RoundChoice, require_course
from exidyn.acquire.study.rounds import CHOICE, next_round
from exidyn.identification.errors import NotAFile
from exidyn.identification.schema import checked

from ...parts.small.small_choice import choice


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"offers": []}, "offers: expected a run, as the verdict is run"),
        ({"chosen": None}, "chosen: expected a run where the verdict is run"),
        ({"chosen": {"plan": "../../x.toml"}}, "chosen.*plan: expected a path below the folder of the study"),
        ({"chosen": {}}, "chosen.*plan: expected a plan or a recording"),
        ({"verdict": "later"}, r"verdict: expected one of run, decided"),
        ({"shapes": [["joint_spring", [3], "", {}]]}, r"expected the number of a joint, from 1 to 2"),
        ({"moved": "long"}, "moved: expected float"),
        ({"items": [{"words": "x"}]}, r"items\[0\].*missing"),
    ],
)
def test_what_cannot_be_is_named(tmp_path, changed, message):
    one = next_round(tmp_path)
    one.diagnosis.mkdir(parents=True)
    (one.diagnosis / CHOICE).write_text(json.dumps(choice("run") | changed))
    with pytest.raises(NotAFile, match=f"{CHOICE}: .*{message}"):
        one.choice  # noqa: B018


def test_rounds_that_are_no_course_are_refused(tmp_path):
    ended, goes_on = (checked(choice(verdict), RoundChoice, "") for verdict in ("decided", "run"))
    require_course(tmp_path, [("round-01", goes_on), ("round-02", ended)])
    with pytest.raises(NotAFile, match="round-01 ended the study, but round-02 follows"):
        require_course(tmp_path, [("round-01", ended), ("round-02", goes_on)])
    other = replace(goes_on, left_over_noise={"wrist": 1.0})
    with pytest.raises(NotAFile, match="round-01 and round-02 have different joints"):
        require_course(tmp_path, [("round-01", goes_on), ("round-02", other)])
