"""What is wanted, in words: the parameters that they stand for, and the nearest where they stand for none."""

import pytest

from exidyn.trajectories.errors import UnknownChoice
from exidyn.trajectories.planning.wishes import wanted_names

NAMES = "MX1R YY1R Fv1 Fc1 Off1 MX2R Fv2 Fc2 Ia2 Kr K0 gain1 gain2 MXL XXL".split()
JOINTS = ("shoulder", "elbow")

WANTED = {
    ("Kr", "Fv", "gain 1"): ["Kr", "Fv", "gain1"],
    "kr, k0": ["Kr", "K0"],
    "K_r, gain of joint 2": ["Kr", "gain2"],
    "gain of elbow": ["gain2"],
    "gains of joint 1": ["gain1"],
    "friction of Shoulder": ["Fv1", "Fc1"],
    "rotor inertia of joint 2": ["Ia2"],
    "mass of joint 1": ["MX1R"],
    "inertia": ["YY1R"],
    "payload": ["MXL", "XXL"],
}


@pytest.mark.parametrize("words", WANTED)
def test_words_stand_for_parameters(words):
    phrases = [words] if isinstance(words, str) else words
    assert wanted_names(phrases, NAMES, JOINTS, ("", "L")) == WANTED[words]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("frction", r"called 'frction'; did you mean '.*friction.*'\? Valid: "),
        ("K_s", r"called 'K_s'; did you mean '.*'\? Valid: "),
        ("gian2", r"called 'gian2'; did you mean '.*gain2.*'\? Valid: "),
        ("payload", "no base parameter called 'payload'"),
        ("gain of joint 3", "no base parameter called 'gain of joint 3'"),
        ("friction of wrist", "no base parameter called 'friction of wrist'"),
    ],
)
def test_what_there_is_not_is_refused_and_the_nearest_named(words, message):
    names = [name for name in NAMES if not name.endswith("L")]
    with pytest.raises(UnknownChoice, match=message):
        wanted_names([words], names, JOINTS, ("", "L"))
