"""External torques in a copy of a recording: all that was recorded is unchanged, and the rest is added."""

from dataclasses import replace

import numpy as np
import pytest
from mcap.reader import make_reader

from exidyn.acquire.command_line import main
from exidyn.identification.contact.contact import contact
from exidyn.identification.contact.contact_file import CONTACT_FROM, FORCE, SETTING, TORQUE, write_contact
from exidyn.identification.errors import NotAFile, RecordingError
from exidyn.identification.recordings.mcap import cdr
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.mcap.mcap_records import read_contents
from exidyn.identification.recordings.recording import Event

from ...parts.small import small_fit, two_joint_files

ADDED = (TORQUE, CONTACT_FROM, FORCE)


@pytest.fixture(scope="module")
def result():
    free = [two_joint_files.run(f"free{k}", 3 + k, 9 + k) for k in range(2)]
    return contact(small_fit.fit(), loaded(), free)


def loaded():
    """A run with a payload that it does not state, a host clock that is late, and an event."""
    recording = two_joint_files.loaded()
    time = recording.signals["position"].time
    host_time = 1_700_000_000_000_000_000 + np.rint(1.001e9 * time).astype(np.int64)
    return replace(recording, host_time=host_time, events=(Event(2.0, "stage", "running"),))


@pytest.fixture(scope="module")
def files(result, tmp_path_factory):
    """Paths of the recording and of its copy with external torques."""
    folder = tmp_path_factory.mktemp("contact")
    write_recording(loaded(), folder / "loaded.mcap")
    return folder / "loaded.mcap", write_contact(result, folder / "copy.mcap", folder / "loaded.mcap")


def messages(path):
    """Topic, log time, publish time and body of all messages, in the order of another reader."""
    with path.open("rb") as file:
        return [
            (channel.topic, message.log_time, message.publish_time, message.data)
            for _, channel, message in make_reader(file).iter_messages()
        ]


def numbers(path, topic, count):
    """Publish times [ns], log times [ns] and numbers of a topic."""
    rows = [row for row in messages(path) if row[0] == topic]
    body = np.frombuffer(b"".join(row[3] for row in rows), cdr.double_array(count).dtype)
    return np.array([row[2] for row in rows]), np.array([row[1] for row in rows]), body["data"]


def test_all_that_was_recorded_is_unchanged(files):
    original, copied = (read_contents(path) for path in files)
    assert copied.finished
    assert not copied.lost
    recorded = [row for row in messages(files[1]) if row[0] not in ADDED and b"exidyn.contact" not in row[3]]
    assert len(recorded) < len(messages(files[1])) - 3
    assert sorted(recorded) == sorted(messages(files[0]))
    assert copied.metadata["exidyn"] == original.metadata["exidyn"]
    assert copied.metadata["settings"].items() >= original.metadata["settings"].items()
    assert {name: part.data for name, part in copied.attachments.items()} == {
        name: part.data for name, part in original.attachments.items()
    }
    original, copied = map(read_recording, files)
    assert copied.signals.keys() == original.signals.keys()
    for name, signal in original.signals.items():
        np.testing.assert_array_equal(copied.signals[name].values, signal.values)


def test_added_topics_hold_the_estimates_at_their_times(files, result):
    known = np.all(np.isfinite(result.estimates.torque), axis=1)
    content = {
        TORQUE: result.estimates.torque,
        CONTACT_FROM: result.threshold.torque(result.estimates),
        FORCE: result.wrench,
    }
    epoch = int(read_contents(files[1]).metadata["exidyn"]["epoch_ns"])
    for topic, values in content.items():
        published, logged, data = numbers(files[1], topic, values.shape[1])
        np.testing.assert_array_equal(data, values[known])
        seconds = (published - epoch) * 1e-9
        np.testing.assert_allclose(seconds, result.estimates.time[known], atol=1e-9)
        np.testing.assert_allclose(logged - epoch, 1.001 * (published - epoch), atol=10)
    details = {c.topic: c.metadata for c in read_contents(files[1]).channels.values()}
    assert details[TORQUE] == {"fields": "shoulder,elbow", "unit": "N m,N m"}
    assert details[FORCE]["unit"] == "N,N,N,N m,N m,N m"


def test_contacts_are_events_only_with_a_threshold(files, result, capsys, tmp_path):
    recording = read_recording(files[1])
    first, *contacts = sorted(recording.events, key=lambda event: event.kind == "contact")
    assert (first.kind, first.text) == ("stage", "running")
    assert [event.time for event in contacts] == pytest.approx([alarm.start for alarm in result.alarms])
    assert contacts[0].details["until"] == result.alarms[0].end
    assert recording.settings[SETTING].startswith("estimated with the fit of empty, loaded; ")
    assert main(["info", str(files[1])]) == 0
    printed = capsys.readouterr().out
    assert "external torques: " in printed
    assert "1 contact at a false-alarm rate of 1 per hour" in " ".join(printed.split())
    assert f"s  contact   {contacts[0].text}" in printed
    assert "warning" not in printed
    path = contact(small_fit.fit(), loaded()).save(tmp_path / "copy.mcap", files[0])
    assert {row[0] for row in messages(path)} & set(ADDED) == {TORQUE, FORCE}
    assert len(read_recording(path).events) == 1


def test_without_drive_gains_torques_are_in_amperes_and_there_is_no_force(files, tmp_path):
    fit = small_fit.plain_fit()
    robot = replace(fit.model.robot, drive_gain=np.ones(2))
    bare = replace(fit, model=replace(fit.model, robot=robot))
    path = contact(bare, loaded()).save(tmp_path / "copy.mcap", files[0])
    details = {c.topic: c.metadata for c in read_contents(path).channels.values()}
    assert details[TORQUE]["unit"] == "A,A"
    assert FORCE not in details


def test_a_copy_is_refused_that_would_be_wrong(files, result, tmp_path):
    target = tmp_path / "copy.mcap"
    with pytest.raises(RecordingError, match="already has external torques; use the original"):
        write_contact(result, target, files[1])
    with pytest.raises(RecordingError, match="exists, and recordings are not overwritten"):
        write_contact(result, files[0], files[0])
    with pytest.raises(RecordingError, match="is a recording of loaded, not of other"):
        replace(result, run="other").save(target, files[0])
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(files[0].read_bytes()[:-3000])
    with pytest.raises(RecordingError, match="Recover it first"):
        write_contact(result, target, cut)
    (tmp_path / "run.csv").write_text("t,q1\n0,0\n")
    with pytest.raises(NotAFile, match="is not an MCAP file"):
        write_contact(result, target, tmp_path / "run.csv")
    assert not target.exists()
