"""Frames of the external torques of an arm that is watched, for the process that shows them.

The head is JSON, and each sample is binary: time, torque, threshold and position of each joint, and force.
Contacts are events whose controller_time is the time of the sample [ns].
"""

import json
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import model_text, parse_model

from .frames import HEAD, SAMPLE, frame, text_frame


class ContactHead(NamedTuple):
    """Description of the arm, the first frame."""

    model: Model  # model of the arm
    unit: str  # unit of the torques
    force: bool  # whether the force on the flange is known

    def frame(self) -> bytes:
        """The head as a frame."""
        return text_frame(HEAD, {**self._asdict(), "model": model_text(self.model)})

    @classmethod
    def read(cls, body: bytes) -> "ContactHead":
        """Read a head from the body of its frame."""
        content = json.loads(body)
        return cls(parse_model(content["model"]), content["unit"], content["force"])


class ContactRows(NamedTuple):
    """External torques to be drawn; unknown values are NaN."""

    time: np.ndarray  # time, shape (t,) [s]
    torque: np.ndarray  # external torques, shape (t, n) [N m]
    limit: np.ndarray  # torque at which each joint alone makes an alarm, shape (t, n) [N m]
    position: np.ndarray  # joint positions, shape (t, n) [rad]
    force: np.ndarray  # force on the flange in the axes of the base, shape (t, 3) [N]

    def frames(self) -> Iterator[bytes]:
        """One frame per row."""
        for row in np.column_stack(self).astype("<f8", copy=False):
            yield frame(SAMPLE, row.tobytes())

    @classmethod
    def read(cls, bodies: Sequence[bytes]) -> "ContactRows":
        """Read rows from the bodies of their frames."""
        rows = np.array([np.frombuffer(body, "<f8") for body in bodies])
        n = (rows.shape[1] - 4) // 3
        return cls(rows[:, 0], *np.split(rows[:, 1:], [n, 2 * n, 3 * n], axis=1))
