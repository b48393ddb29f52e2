"""Every parser reads a damaged file or refuses it in one line; nothing else comes out of it."""

import pytest

from exidyn.drivers.errors import BadSettings
from exidyn.identification.errors import BrokenTree, ExidynError, RecordingError, RobotError, listed
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.urdf import parse_urdf

from ...parts.fuzz import fuzz
from ...parts.fuzz.fuzz_parsers import PARSERS
from ...parts.runs import parser_files
from ...parts.small import two_joints

pytestmark = pytest.mark.slow

INPUTS = 40
"""Inputs of each parser, fewer of a slow one."""


@pytest.mark.parametrize("name", PARSERS)
def test_damaged_files_are_read_or_refused_in_one_line(name, tmp_path):
    count = max(INPUTS // PARSERS[name].slow, 8)
    outcome = fuzz.fuzz(name, count, tmp_path / "input")
    assert not outcome.failures
    assert outcome.inputs == count
    assert outcome.refused > 0
    assert len(outcome.longest) <= fuzz.LONGEST


@pytest.mark.parametrize("name", PARSERS)
def test_valid_files_are_read(name, tmp_path):
    for chosen in PARSERS[name].damages():
        folder = tmp_path / "input"
        content = chosen.finish(chosen.files[chosen.name])
        parser_files.write({**chosen.files, chosen.name: content}, folder)
        PARSERS[name].read(folder, chosen.name)


@pytest.mark.parametrize("number", ["99999999999999999999", "-99999999999999999999", "0x" + "f" * 5000])
def test_whole_numbers_that_toml_does_not_have_are_refused(number, tmp_path):
    path = tmp_path / "robot.toml"
    text = parser_files.robots()["cobot.toml"]["cobot.toml"].decode()
    path.write_text(text.replace("inertial_tolerance = 0.1", f"inertial_tolerance = {number}"))
    with pytest.raises(RobotError, match="inertial_tolerance: a whole number of more than 64 bits"):
        read_model(path)


@pytest.mark.parametrize("key", ["lower", "upper", "velocity", "effort"])
def test_limits_of_a_urdf_are_numbers(key):
    value = {"lower": "-2.5", "upper": "2.5", "velocity": "3.0", "effort": "200"}[key]
    with pytest.raises(BrokenTree, match=f'<limit {key}="fast">: expected 1 finite number'):
        parse_urdf(parser_files.URDF.replace(f'{key}="{value}"', f'{key}="fast"', 1))


@pytest.mark.parametrize("value", ["inf", "-inf", "nan", "1e15", "-3", "1.5"])
@pytest.mark.parametrize("code", ["220", "221"])
def test_counts_and_columns_of_a_trace_are_whole_numbers(code, value, tmp_path):
    name, files = "run_NextGenDrive#1.dat", parser_files.trace()
    lines = files[name].decode("iso-8859-1").split("\r\n")
    place = max(k for k, line in enumerate(lines) if line.startswith(f"{code},"))
    lines[place] = f"{code},{value}"
    parser_files.write({**files, name: "\r\n".join(lines).encode("iso-8859-1")}, tmp_path / "trace")
    with pytest.raises(RecordingError, match=f"{name}: channel Iststrom: {code}"):
        import_source(tmp_path / "trace", two_joints.model())


def test_messages_are_one_line_and_lists_show_what_is_most_alike():
    for kind in (ExidynError, BadSettings):
        text = str(kind(f"robot.toml: expected a number;\n found {'9' * 5000}\x1b[31m. Give one"))
        assert len(text) <= fuzz.LONGEST - len(fuzz.COMMAND)
        assert text.startswith("robot.toml: expected a number; found 999")
        assert text.endswith("\\x1b[31m. Give one")
    assert str(ExidynError("short")) == "short"
    names = [f"parameter_{k}" for k in range(100)]
    text = listed(names, "parameter_77")
    assert text.startswith("parameter_77, ")
    assert text.endswith(" more")
    assert listed(["a", "b"], "c") == "a, b"
    assert listed([]) == "none"
