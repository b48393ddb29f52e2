"""PACE's parameter vector: a file of PyTorch, read by an unpickler that has only what such files may use."""

import io
import pickle
import zipfile
from collections import OrderedDict
from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.servo_law import ServoLaw
from exidyn.identification.export import FORMATS
from exidyn.identification.export.pace import tensor_file

from ...parts.runs.robots import six_axis
from .test_sdf import portable


class Unpickler(pickle.Unpickler):
    """Reads one tensor in the way of `torch.load`, as an array."""

    def __init__(self, archive):
        super().__init__(io.BytesIO(archive.read("archive/data.pkl")))
        self.archive = archive

    def find_class(self, module, name):
        return {
            ("torch._utils", "_rebuild_tensor_v2"): self.rebuilt,
            ("torch", "FloatStorage"): "<f4",
            ("collections", "OrderedDict"): OrderedDict,
        }[module, name]

    def persistent_load(self, saved):
        kind, numbers, key, device, count = saved
        assert (kind, device) == ("storage", "cpu")
        return np.frombuffer(self.archive.read(f"archive/data/{key}"), numbers, count)

    def rebuilt(self, storage, offset, size, stride, gradient, hooks):
        assert (offset, stride, gradient, hooks) == (0, (1,), False, {})
        return storage[: size[0]]


def tensor(content):
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert archive.read("archive/version") == b"3\n"
        return Unpickler(archive).load()


def test_the_vector_is_in_the_order_of_pace():
    delay = np.full(6, 0.02)
    arm = portable(six_axis())
    arm = replace(arm, servos=ServoLaw.of(*np.ones((3, 6)), delay))
    vector, n = tensor(FORMATS["pace"].text(arm)), 6
    assert vector.shape == (4 * n + 1,)
    for place, values in enumerate((arm.joints.armature, arm.joints.damping, arm.joints.dry, np.zeros(n))):
        np.testing.assert_allclose(vector[place * n : (place + 1) * n], values, rtol=1e-6)
    assert vector[-1] == pytest.approx(0.02 / 0.0025)
    left = FORMATS["pace"].leaves_out(arm)
    assert any("PACE delays torques" in line for line in left)
    assert any(line.startswith("position servos") for line in left)


def test_one_delay_stands_for_all():
    arm = replace(portable(six_axis()), servos=ServoLaw.of(*np.ones((3, 6)), np.linspace(0.0, 0.02, 6)))
    assert tensor(FORMATS["pace"].text(arm))[-1] == pytest.approx(4.0)
    assert "different delays of the joints: all have the mean, 0.01 s" in FORMATS["pace"].leaves_out(arm)


@pytest.mark.parametrize("count", [1, 25, 300])
def test_pytorch_reads_the_file(count, tmp_path):
    torch = pytest.importorskip("torch")
    values = np.random.default_rng(0).normal(size=count)
    (tmp_path / "mean_000.pt").write_bytes(tensor_file(values))
    np.testing.assert_allclose(torch.load(tmp_path / "mean_000.pt").numpy(), values, rtol=1e-6)
