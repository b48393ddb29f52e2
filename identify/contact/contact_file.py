"""External torques in a recording: a copy of its file with topics that no reader takes for measured ones."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ..errors import RecordingError
from ..notebook import counted
from ..recordings.mcap.mcap_copy import add_topics
from ..recordings.mcap.mcap_topics import ARRAY, EVENTS, Topic, event_message, state_messages
from ..recordings.mcap.mcap_writer import of_any_length
from ..recordings.recording import Event
from .alarms import Alarm
from .contact import Contact

TORQUE, CONTACT_FROM, FORCE = "/external_torque", "/contact_from", "/flange_force"
"""Topics of the external torques, of the torques from which they count as contact, and of the wrench."""
SETTING = "external torques"
"""Setting of a recording that has these topics; its text names the fit."""
WRENCH = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
"""Names of the six numbers of a wrench."""


def write_contact(result: Contact, path: Path | str, recording: Path | str) -> Path:
    """Write a copy of the run's recording that also has the external torques; return its path.

    The copy has all that was recorded, unchanged, and the topics /external_torque, /contact_from and
    /flange_force. Contacts are events.

    Args:
        result: External torques along the run.
        path: Path of the copy (.mcap).
        recording: Path of the recording (.mcap).

    Raises:
        NotAFile: `recording` is not a recording of exidyn.
        RecordingError: It is another run, is damaged, or already has external torques; or `path` exists.
    """
    source, target = Path(recording), Path(path)
    if target.exists():
        raise RecordingError(f"{target} exists, and recordings are not overwritten. Choose another name")
    contacts = "no threshold of contact"
    if result.threshold is not None:
        rate = f"{result.threshold.alarms_per_hour:g} per hour"
        contacts = f"{counted(len(result.alarms), 'contact')} at a false-alarm rate of {rate}"
    words = f"estimated with the fit of {', '.join(result.fit.runs)}; {contacts}"
    add_topics(source, target, result.run, _content(result), {SETTING: words})
    return target


def _content(result: Contact) -> Iterator[tuple[Topic, np.ndarray, np.ndarray]]:
    """Topics, times [s] and messages: those of samples in which the torques are known."""
    estimates, robot = result.estimates, result.fit.model.robot
    known = np.all(np.isfinite(estimates.torque), axis=1)
    time, units = estimates.time[known], robot.units("A" if result.fit.unscaled else "N m")
    columns: dict[str, tuple[np.ndarray, Sequence[str], Sequence[str]]] = {
        TORQUE: (estimates.torque, robot.joints, units)
    }
    if result.threshold is not None:
        columns[CONTACT_FROM] = result.threshold.torque(estimates), robot.joints, units
    if not result.fit.unscaled:
        columns[FORCE] = result.wrench, WRENCH, ("N",) * 3 + ("N m",) * 3
    for name, (values, fields, unit) in columns.items():
        details = {"fields": ",".join(fields), "unit": ",".join(unit)}
        yield Topic(name, ARRAY, {}, details), time, state_messages(values[known])
    if result.alarms:
        events = [_event(result, alarm) for alarm in result.alarms]
        messages = of_any_length([event_message(event) for event in events])
        yield EVENTS, np.array([event.time for event in events]), messages


def _event(result: Contact, alarm: Alarm) -> Event:
    """Contact as an event at its start."""
    joint = result.fit.model.robot.joints[alarm.joint]
    details = {"joint": joint, "until": alarm.end, "torque": alarm.torque.tolist(), "score": alarm.score}
    return Event(alarm.start, "contact", f"{joint}, until {alarm.end:.2f} s", details)
