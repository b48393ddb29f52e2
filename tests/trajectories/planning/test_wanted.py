"""What is wanted, in words: the parameters that they stand for, and the nearest where they stand for none."""

import pytest

from exidyn.trajectories.errors import UnknownChoice
from exidyn.trajectories.planning.wanted import wanted_names

NAMES = [
    "MX1R",
    "YY1R",
    "Fv1",
    "Fc1",
    "Off1",
    "MX2R",
    "Fv2",
    "Fc2",
    "Ia2",
    "Kr",
    "K0",
    "gain1",
    "gain2",
    "MXL",
    "XXL",
]
JOINTS = ("shoulder", "elbow")

WANTED = {
    "K_r": ["Kr"],
    "kr, k0": ["Kr", "K0"],
    "K_r, gain of joint 2": ["Kr", "gain2"],
    "gain 2": ["gain2"],
    "gain of elbow": ["gain2"],
    "gain": ["gain"],
    "gains of joint 1": ["gain1"],
    "friction of Shoulder": ["Fv1", "Fc1"],
    "friction": ["Fv1", "Fc1", "Fv2", "Fc2"],
    "rotor inertia of joint 2": ["Ia2"],
    "mx2": ["MX2R"],
    "mass of joint 1": ["MX1R"],
    "inertia": ["YY1R"],
    "payload": ["MXL", "XXL"],
}


@pytest.mark.parametrize("words", WANTED)
def test_words_stand_for_parameters(words):
    assert wanted_names([words], NAMES, JOINTS, ("", "L")) == WANTED[words]


def test_several_arguments_are_several_wishes():
    assert wanted_names(["Kr", "Fv", "gain 1"], NAMES, JOINTS, ("",)) == ["Kr", "Fv", "gain1"]


@pytest.mark.parametrize(
    ("words", "meant"),
    [("frction", "friction"), ("K_s", "K"), ("gian2", "gain2")],
)
def test_the_nearest_is_named(words, meant):
    with pytest.raises(UnknownChoice, match=rf"called '{words}'; did you mean '.*'\? Valid: ") as error:
        wanted_names([words], NAMES, JOINTS, ("",))
    assert meant in str(error.value)


@pytest.mark.parametrize("words", ["payload", "gain of joint 3", "friction of wrist"])
def test_what_there_is_not_is_refused(words):
    names = [name for name in NAMES if not name.endswith("L")]
    with pytest.raises(UnknownChoice, match=f"no base parameter called '{words}'"):
        wanted_names([words], names, JOINTS, ("", "L"))
