"""Traces of KUKA controllers."""

import struct
from pathlib import Path

import numpy as np
import pytest

from exidyn.identification.errors import NotAFile, RecordingError, WrongShape
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording

from ...parts.runs.runs import TIME, model, motion, noise, require


def trace(
    path: Path, period: float, channels: list[tuple], layout: str = "BLOCK", german: bool = True, cut: int = 0
) -> None:
    """Write a header and its data, value by value; channels are (name, unit, values, factor, offset)."""
    count = len(channels[0][2])
    words = ("IMPLIZIT", "EXPLIZIT") if german else ("IMPLICIT", "EXPLICIT")
    lines = ["DIAEXTENDED  {@:ENGLISH", "#BEGINGLOBALHEADER", "101,KRC trace", "#ENDGLOBALHEADER"]
    lines += ["#BEGINCHANNELHEADER", "200,Zeit", "201,", "202,s", f"210,{words[0]}", f"220,{count}", "240,0"]
    lines += [f"241,{period}", "#ENDCHANNELHEADER"]
    for place, (name, unit, _, factor, offset) in enumerate(channels):
        first = place + 1 if layout == "BLOCK" else place * count + 1
        lines += ["#BEGINCHANNELHEADER", f"200,{name}", "201,Überschrift", f"202,{unit}", f"210,{words[1]}"]
        lines += [f"211,{path.stem}.r64", f"213,{layout}", "214,REAL64", f"220,{count}", f"221,{first}"]
        lines += [f"240,{offset}", f"241,{factor}", "#ENDCHANNELHEADER"]
    path.write_bytes("\r\n".join(lines).encode("iso-8859-1"))
    raw = [[(value - offset) / factor for value in values] for _, _, values, factor, offset in channels]
    order = (
        [v for row in zip(*raw, strict=True) for v in row]
        if layout == "BLOCK"
        else [v for c in raw for v in c]
    )
    data = b"".join(struct.pack("<d", value) for value in order)
    path.with_suffix(".r64").write_bytes(data[: len(data) - cut])


def write_traces(
    folder: Path, layout: str = "BLOCK", german: bool = True, cut: int = 0
) -> tuple[np.ndarray, ...]:
    position, current, torque = np.degrees(motion()), noise(), 100 * noise(seed=1)
    kelvin = 310.0 + noise(seed=2)
    for axis in range(2):
        channels = [
            ("Sollposition", "°", position[:, axis] + 0.001, 1e-6, 0.0),
            ("Istposition", "°", position[:, axis], 1e-6, 10.0),
            ("Unbekannt", "furlong", torque[:, axis], 1.0, 0.0),
            ("Iststrom", "A", current[:, axis], 0.5, 0.0),
            ("Istmoment", "Nm", torque[:, axis], 1.0, 0.0),
            ("Motortemperatur", "K", kelvin[:, axis], 1.0, 0.0),
        ]
        trace(folder / f"Lauf 7_NextGenDrive#{axis + 1}.dat", 0.004, channels, layout, german, cut)
    ipo = [(f"AxisPos_CmdIpo{axis + 1}", "°", position[::3, axis], 1.0, 0.0) for axis in range(2)]
    trace(folder / "Lauf 7_KRCIpo.dat", 0.012, ipo, layout, german)
    return position, current, torque, kelvin


@pytest.mark.parametrize(("layout", "german"), [("BLOCK", True), ("CHANNEL", False)])
def test_kuka_traces_of_all_drives_are_one_run(tmp_path, layout, german):
    position, current, torque, kelvin = write_traces(tmp_path, layout, german)
    [found] = import_source(tmp_path, model())
    assert found.name == "Lauf 7"
    signals = found.signals
    np.testing.assert_allclose(signals["position"].values, np.radians(position), atol=1e-12)
    np.testing.assert_allclose(signals["current"].values, current, atol=1e-12)
    np.testing.assert_allclose(signals["torque"].values, torque, atol=1e-12)
    np.testing.assert_allclose(signals["temperature"].values, kelvin - 273.15, atol=1e-9)
    np.testing.assert_allclose(signals["command"].values, np.radians(position + 0.001), atol=1e-12)
    np.testing.assert_allclose(signals["position"].time, TIME, atol=1e-9)
    assert found.warnings == ()


def test_kuka_axes_that_count_otherwise_than_the_robots_description(tmp_path):
    position, current, torque, _ = write_traces(tmp_path)
    [found] = import_source(tmp_path, model(), sign=[1, -1], zero=[0.0, 0.5])
    signals = found.signals
    np.testing.assert_allclose(
        signals["position"].values, np.radians(position) * [1, -1] + [0, 0.5], atol=1e-12
    )
    np.testing.assert_allclose(signals["torque"].values, torque * [1, -1], atol=1e-12)
    np.testing.assert_allclose(signals["current"].values, current, atol=1e-12)
    with pytest.raises(WrongShape, match="expected 1 or -1, and a position, for each of 2 joints"):
        import_source(tmp_path, model(), sign=[1, 180])


def test_kuka_interpolator_alone_gives_commands_at_its_own_rate(tmp_path):
    position, current, *_ = write_traces(tmp_path)
    for axis in range(2):
        channels = [
            ("Istposition", "Grad", position[:, axis], 1.0, 0.0),
            ("Iststrom", "A", current[:, axis], 1.0, 0.0),
        ]
        trace(tmp_path / f"Lauf 7_NextGenDrive#{axis + 1}.dat", 0.004, channels)
    [found] = import_source(tmp_path / "Lauf 7_NextGenDrive#1.dat", model())
    assert found.signals["position"].period == pytest.approx(0.004)
    assert found.signals["command"].period == pytest.approx(0.012)
    require(found, command=np.radians(position[::3]), atol=1e-12)


def test_kuka_unknown_units_are_left_out_with_a_warning(tmp_path):
    position, current, *_ = write_traces(tmp_path)
    for axis in range(2):
        channels = [
            ("Istposition", "°", position[:, axis], 1.0, 0.0),
            ("Iststrom", "A", current[:, axis], 1.0, 0.0),
            ("Istmoment", "%", current[:, axis], 1.0, 0.0),
        ]
        trace(tmp_path / f"Lauf 7_NextGenDrive#{axis + 1}.dat", 0.004, channels)
    [found] = import_source(tmp_path, model())
    assert "torque" not in found.signals
    assert "Istmoment was left out: its unit is '%'" in found.warnings[0]


def test_kuka_data_cut_off_are_read_up_to_the_cut(tmp_path):
    position, *_ = write_traces(tmp_path, cut=6 * 8 * 20 + 3)
    [found] = import_source(tmp_path, model())
    assert found.signals["position"].values.shape == (179, 2)
    require(found, position=np.radians(position[:179]), atol=1e-12)
    assert "Lauf 7_NextGenDrive#1.r64 ends abruptly: 179 of 200 samples are present" in found.warnings


def test_kuka_traces_that_are_not_whole_are_reported(tmp_path):
    write_traces(tmp_path)
    with pytest.raises(RecordingError, match="axis 2, but small has 1"):
        import_source(tmp_path, model(joints=1))
    with pytest.raises(
        RecordingError, match="current of axis3 is (not finite|empty)|position of axis3 is (not finite|empty)"
    ):
        import_source(tmp_path, model(joints=3))
    with pytest.raises(NotAFile, match="no trace other. Traces here: Lauf 7"):
        import_source(tmp_path, model(), name="other")
    (tmp_path / "Lauf 7_NextGenDrive#1.r64").unlink()
    with pytest.raises(NotAFile, match="which is not beside it"):
        import_source(tmp_path, model())
    (tmp_path / "Lauf 7_NextGenDrive#1.dat").write_text("hello")
    with pytest.raises(NotAFile, match="is not a DIAdem header"):
        import_source(tmp_path, model())


def test_external_axes_are_kept_beside_the_arm(tmp_path):
    position, *_ = write_traces(tmp_path)
    rail = 1000.0 + np.arange(len(TIME))
    channels = [("Istposition", "mm", rail, 1.0, 0.0), ("Iststrom", "A", noise()[:, 0], 1.0, 0.0)]
    trace(tmp_path / "Lauf 7_NextGenDrive#7.dat", 0.004, channels)
    [found] = import_source(tmp_path, model())
    require(found, position=np.radians(position), atol=1e-12)
    assert list(found.controller.words) == ["current E1", "position E1"]
    np.testing.assert_allclose(found.controller.of("position E1"), 1e-3 * rail, atol=1e-9)
    assert "external axes are kept, and not identified: current E1, position E1" in found.warnings
    write_recording(found, tmp_path / "run.mcap")
    again = read_recording(tmp_path / "run.mcap").controller
    np.testing.assert_allclose(again.of("position E1"), 1e-3 * rail, atol=1e-9)
