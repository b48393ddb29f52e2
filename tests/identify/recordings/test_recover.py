"""What a crash left becomes a whole file; what is lost is reported."""

import numpy as np
import pytest
from mcap.reader import make_reader

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.commands.info_command import LOST, target_of
from exidyn.identification.errors import ExidynError
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.mcap.mcap_records import recover

from ...parts.runs.recorded import cycle, end, event, head, record

pytestmark = pytest.mark.clocked(patient=True)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("recover") / "run.mcap"
    record(path, [head().frame(), event(0, text="begun"), *map(cycle, range(1500)), end()])
    return path


def messages(path):
    with open(path, "rb") as stream:
        return [
            (channel.topic, schema.name, message.log_time, message.publish_time, message.data)
            for schema, channel, message in make_reader(stream).iter_messages(log_time_order=False)
        ]


@pytest.fixture
def cut(run, tmp_path):
    """The first 70 per cent of a recording, as a part."""
    path = tmp_path / "run.mcap.part"
    data = run.read_bytes()
    path.write_bytes(data[: int(0.7 * len(data))])
    return path


def test_a_part_becomes_a_whole_file_that_other_readers_open(run, cut, capsys):
    before = cut.read_bytes()
    assert main(["info", "--repair", str(cut)]) == LOST
    text = capsys.readouterr()
    whole = cut.with_suffix("")
    found, expected = messages(whole), messages(run)
    assert 0.5 * len(expected) < len(found) < len(expected)
    assert found == expected[: len(found)]
    assert f"{len(found)} messages in " in text.out
    assert "lost: whatever came after the end of the file" in text.err
    assert cut.read_bytes() == before
    assert sorted(file.name for file in cut.parent.iterdir()) == ["run.mcap", "run.mcap.part"]


def test_what_was_recovered_reads_as_what_was_left_and_reports_it(cut):
    recover(cut, cut.with_name("whole.mcap"))
    left, whole = read_recording(cut), read_recording(cut.with_name("whole.mcap"))
    for name, signal in left.signals.items():
        assert np.array_equal(whole.signals[name].values, signal.values, equal_nan=True), name
        assert np.array_equal(whole.signals[name].time, signal.time)
    assert whole.events == left.events
    assert whole.trajectory == left.trajectory
    assert any(warning.startswith("recovered from run.mcap.part, without") for warning in whole.warnings)
    assert not any("abruptly" in warning for warning in whole.warnings)
    write_recording(whole, cut.with_name("again.mcap"))
    assert read_recording(cut.with_name("again.mcap")).warnings == whole.warnings


def test_a_whole_file_loses_nothing(run, tmp_path, capsys):
    assert main(["info", "--repair", str(run), "--output", str(tmp_path / "copy.mcap")]) == 0
    assert messages(tmp_path / "copy.mcap") == messages(run)
    assert read_recording(tmp_path / "copy.mcap").warnings == read_recording(run).warnings
    assert capsys.readouterr().err == ""


def test_names_of_what_is_recovered(tmp_path):
    part, whole = tmp_path / "run.mcap.part", tmp_path / "run.mcap"
    assert target_of(part) == whole
    whole.touch()
    assert target_of(part) == target_of(whole) == tmp_path / "run.recovered.mcap"


def test_nothing_is_written_over(cut, capsys):
    other = cut.with_name("other.mcap")
    other.write_text("precious")
    assert main(["info", "--repair", str(cut), "--output", str(other)]) == REFUSED
    assert "other.mcap exists and is not written over" in capsys.readouterr().err
    assert other.read_text() == "precious"


def test_what_is_no_recording_is_refused(tmp_path, capsys):
    for name, content in (("empty", b""), ("text", b"hello, world"), ("begin", b"\x89MCAP0\r\n")):
        (tmp_path / name).write_bytes(content)
        assert main(["info", "--repair", str(tmp_path / name)]) == REFUSED
    assert main(["info", "--repair", str(tmp_path / "missing")]) == REFUSED
    assert "there is nothing in it to rescue" in capsys.readouterr().err
    assert {file.name for file in tmp_path.iterdir()} == {"empty", "text", "begin"}


def test_random_damage_leaves_a_file_that_is_whole_or_an_error_of_ours(run, tmp_path):
    data, random = run.read_bytes(), np.random.default_rng(3)
    rescued = 0
    for number in range(20):
        damaged = bytearray(data[: random.integers(len(data) // 2, len(data))])
        for place in random.integers(8, len(damaged), 4):
            damaged[place] ^= 0xFF
        source, target = tmp_path / f"{number}.mcap", tmp_path / f"{number}.whole.mcap"
        source.write_bytes(damaged)
        try:
            found = recover(source, target)
        except ExidynError:
            assert not target.exists()
            continue
        assert found.lost
        assert len(messages(target)) == found.messages
        rescued += found.messages > 0
    assert rescued > 10
