"""exidyn compensate: what it writes, prints and refuses."""

import json

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.feedforward.feedforward import make_feedforward
from exidyn.identification.fit.fit_file import write_fit

from ...parts.small import small_fit

MJCF = """<mujoco><worldbody><body><joint name="shoulder" axis="0 1 0"/><geom size="0.1" mass="1"/>
<body pos="0.4 0 0"><joint name="elbow" axis="0 1 0"/><geom size="0.1" mass="1"/></body></body></worldbody>
<actuator><position joint="shoulder" kp="400"/>{elbow}</actuator></mujoco>"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The working folder, with fit.json, servos.xml and half.xml, in which one joint has no servo."""
    write_fit(small_fit.fit(), tmp_path / "fit.json")
    (tmp_path / "servos.xml").write_text(MJCF.format(elbow='<position joint="elbow" kp="200"/>'))
    (tmp_path / "other.xml").write_text(MJCF.format(elbow="").replace('"elbow"', '"wrist"'))
    (tmp_path / "half.xml").write_text(MJCF.format(elbow=""))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_both_files_are_written_and_the_torques_printed(folder, capsys):
    assert main(["compensate", "fit.json"]) == 0
    printed, notes = capsys.readouterr()
    assert "written: two_joints_feedforward.py, two_joints_feedforward.hpp" in notes
    scope = {}
    exec((folder / "two_joints_feedforward.py").read_text(), scope)
    fit, q = small_fit.fit(), np.array([0.3, -0.8])
    np.testing.assert_allclose(scope["gravity"](q), fit.torque(q, 0 * q, 0 * q), rtol=1e-12)
    assert "namespace exidyn_two_joints" in (folder / "two_joints_feedforward.hpp").read_text()
    assert [line.split()[0] for line in printed.splitlines()[3:5]] == ["shoulder", "elbow"]
    assert "sag" not in printed
    assert printed.startswith("Feedforward: arm two joints with no payload, fit of ")


def test_options_and_json(folder, capsys):
    arguments = ["--payload", "L", "--robot", "servos.xml", "--standstill", "0.1", "--friction", "50"]
    assert main(["compensate", "fit.json", *arguments, "-o", "arm.py", "--json", "-"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["band"], result["share"], result["written"]) == ([0.1, 0.1], 0.5, ["arm.py"])
    for offset, torque, stiffness in zip(result["offset"], result["gravity"], (400.0, 200.0), strict=True):
        assert offset == pytest.approx(torque / stiffness)
    feedforward = make_feedforward(small_fit.fit(), "L", band=0.1, share=0.5)
    friction = feedforward.friction(np.zeros(2), np.full(2, 0.2))
    np.testing.assert_allclose(result["compensated"], 0.5 * friction)
    written = (folder / "arm.py").read_text()
    assert "def position_offset(q):" in written
    assert "arm two joints with payload L" in written


def test_no_payload_has_a_name_as_in_contact(folder):
    for name, arguments in {"default.py": [], "none.py": ["--payload", "none"]}.items():
        assert main(["compensate", "fit.json", *arguments, "-o", name]) == 0
    assert (folder / "default.py").read_text() == (folder / "none.py").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--payload", "X"], "no payload 'X'. Payloads of the fit: L"),
        (["--friction", "100"], "share of friction is 100 %; it must be at least 0 and below 100 %"),
        (["-o", "arm.m"], "--output arm.m: the name must end in .py or .hpp"),
        (["--robot", "half.xml"], "--robot half.xml: not every joint of the fit has a position servo there"),
        (
            ["--robot", "other.xml"],
            "--robot other.xml: not every joint of the fit has a position servo there",
        ),
        (["-o", "missing.json"], "the name must end in .py or .hpp"),
    ],
)
def test_bad_input_gets_one_clear_error(folder, arguments, message, capsys):
    assert main(["compensate", "fit.json", *arguments]) == REFUSED
    assert message in capsys.readouterr().err
    assert not list(folder.glob("*.hpp"))
