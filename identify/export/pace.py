"""PACE (github.com/leggedrobotics/pace-sim2real): the vector of its parameters, as its fits save it.

`mean_000.pt` is one tensor: armature, viscous friction, static friction and encoder bias of all joints in the
order of the arm, and one delay of all torques in simulation steps. PyTorch's file is a ZIP archive with a
pickle that refers to raw numbers.
"""

import io
import struct
import zipfile

import numpy as np

from .portable import Portable

FEATURES = ("armature", "damping", "dry", "delay")
STEP = 0.0025
"""Step of PACE's simulation [s]."""
EPOCH = (1980, 1, 1, 0, 0, 0)
"""Date of all files in the archive, so that equal models have equal files."""


def pace(portable: Portable) -> bytes:
    """PyTorch tensor for PACE (mean_000.pt): armature, viscous and dry friction, no encoder bias, delay."""
    joints = portable.joints
    parts = [joints.armature, joints.damping, joints.dry, np.zeros(portable.robot.dof)]
    return tensor_file(
        np.array([*np.maximum(np.concatenate(parts), 0.0), np.mean(portable.law.delay) / STEP])
    )


def pace_notes(portable: Portable) -> list[str]:
    """Sentences on the parts of the model that PACE's parameters approximate."""
    delays = portable.law.delay
    if not np.any(delays):
        return []
    notes = ["a delay of commands alone: PACE delays torques, and so what the servos measure too"]
    if np.any(delays != delays[0]):
        notes.append(f"different delays of the joints: all have the mean, {np.mean(delays):.4g} s")
    return notes


def tensor_file(values: np.ndarray) -> bytes:
    """File from which `torch.load` reads the values (n,) as a tensor in single precision."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_STORED) as archive:
        for name, data in (
            ("data.pkl", _pickled_tensor(len(values))),
            ("byteorder", b"little"),
            ("data/0", np.asarray(values, "<f4").tobytes()),
            ("version", b"3\n"),
        ):
            archive.writestr(zipfile.ZipInfo(f"archive/{name}", EPOCH), data)
    return content.getvalue()


def _pickled_tensor(count: int) -> bytes:
    """Pickle of a tensor (count,) that refers to the numbers in `data/0`, without PyTorch."""
    size = b"J" + struct.pack("<i", count)
    storage = b"(" + _text("storage") + b"ctorch\nFloatStorage\n" + _text("0") + _text("cpu") + size + b"tQ"
    offset, shape, stride, no_gradient = b"K\0", size + b"\x85", b"K\1\x85", b"\x89"
    hooks = b"ccollections\nOrderedDict\n)R"
    arguments = b"(" + storage + offset + shape + stride + no_gradient + hooks + b"t"
    return b"\x80\2ctorch._utils\n_rebuild_tensor_v2\n" + arguments + b"R."


def _text(text: str) -> bytes:
    return b"X" + struct.pack("<I", len(text)) + text.encode()
