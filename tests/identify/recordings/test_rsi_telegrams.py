"""Logs of RSI telegrams, as programs on the other end of a KUKA controller write them."""

import gzip

import numpy as np
import pytest

from exidyn.identification.errors import BadTime, NotAFile, NotRecorded, RecordingError
from exidyn.identification.recordings.importers import import_source, kind_of

from ...parts.runs.runs import model, require

CYCLE, COUNT = 4, 400
"""Milliseconds between telegrams, and telegrams of a run."""
TIME = np.arange(COUNT) * CYCLE * 1e-3
ANGLES = 20.0 * np.sin(np.outer(TIME, 2.0 + np.arange(6)))
AMPERES = 3.0 * np.cos(np.outer(TIME, 1.0 + np.arange(6)))


def attributes(values, letter="A"):
    return " ".join(f'{letter}{k + 1}="{value:.4f}"' for k, value in enumerate(values))


def telegram(k, clock=1000, current="MACur", more=""):
    efforts = f"<{current} {attributes(AMPERES[k])}/>" if current else ""
    end = f'<Delay D="0"/><IPOC>{clock + CYCLE * k}</IPOC></Rob>'
    return f'<Rob TYPE="KUKA"><AIPos {attributes(ANGLES[k])}/>{efforts}{more}{end}'


def telegrams(**options):
    return [telegram(k, **options) for k in range(COUNT)]


def write(path, lines, between="\n"):
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "wt") as file:
        file.write(between.join(lines) + "\n")
    return path


def require_whole(recording, signal="current"):
    require(recording, time=TIME, atol=1e-9)
    require(recording, position=np.radians(ANGLES), atol=1e-6)
    np.testing.assert_allclose(recording.signals[signal].values, AMPERES, atol=1e-4)
    assert recording.warnings == ()


@pytest.mark.parametrize("name", ["rsi.xml", "rsi.txt", "rsi.log", "rsi", "rsi.csv", "rsi.txt.gz"])
def test_telegrams_are_known_by_their_content(tmp_path, name):
    path = write(tmp_path / name, telegrams())
    assert kind_of(path) == "rsi"
    [found] = import_source(path, model(6))
    require_whole(found)
    assert found.name == "rsi"


@pytest.mark.parametrize("between", ["", "\n12:00:00.004 received ", "\n<!-- -->\n\n", "\0\n"])
def test_what_stands_between_telegrams_is_not_read(tmp_path, between):
    require_whole(import_source(write(tmp_path / "rsi.log", telegrams(), between), model(6))[0])


def test_a_telegram_over_several_lines_in_a_document_is_read(tmp_path):
    lines = [line.replace("><", ">\n  <") for line in telegrams()]
    path = write(tmp_path / "rsi.xml", ['<?xml version="1.0"?>', "<Log>", *lines, "</Log>"])
    require_whole(import_source(path, model(6))[0])


def test_answers_are_skipped(tmp_path):
    lines = []
    for k, line in enumerate(telegrams()):
        lines += [
            line,
            f'<Sen Type="ImFree"><AKorr {attributes(ANGLES[k])}/><IPOC>{1000 + CYCLE * k}</IPOC></Sen>',
        ]
    require_whole(import_source(write(tmp_path / "rsi.log", ["# recorded", *lines]), model(6))[0])


@pytest.mark.parametrize("first", [2**32 - 800, 2**31 - 800])
def test_the_clock_may_begin_again(tmp_path, first):
    lines = telegrams(clock=first)
    for k in range(COUNT):
        stamp = first + CYCLE * k
        wrapped = stamp % 2**32 if first > 2**31 else (stamp + 2**31) % 2**32 - 2**31
        lines[k] = lines[k].replace(f"<IPOC>{stamp}<", f"<IPOC>{wrapped}<")
    assert any("<IPOC>-" in line or "<IPOC>0<" in line for line in lines)
    require_whole(import_source(write(tmp_path / "rsi.log", lines), model(6))[0])


def test_telegrams_are_put_in_order_but_not_those_of_a_second_run(tmp_path):
    lines = telegrams()
    lines[10], lines[11] = lines[11], lines[10]
    lines[50:50] = [lines[50], lines[50]]
    require_whole(import_source(write(tmp_path / "rsi.log", lines), model(6))[0])
    path = write(tmp_path / "rsi.log", [*telegrams(clock=900_000), *telegrams()])
    with pytest.raises(BadTime):
        import_source(path, model(6))


def test_damaged_telegrams_are_left_out_counted_or_refused(tmp_path):
    lines = telegrams()
    lines[6] = lines[6][:60]
    lines[7] = lines[7].replace('A3="', 'A3="x')
    lines[8] = lines[8].replace(" A2=", " B2=")  # whose row lacks an axis
    lines[-1] = lines[-1][:-20]
    [found] = import_source(write(tmp_path / "rsi.log", lines), model(6))
    assert len(found.signals["position"]) == COUNT - 4
    assert found.warnings[0] == f"3 of {COUNT} telegrams are damaged and left out, the first in line 7"
    path = write(tmp_path / "rsi.log", [line.replace("</Rob>", "") for line in telegrams()])
    with pytest.raises(NotAFile, match=f"0 telegrams of RSI, .* can be read, and {COUNT} are damaged"):
        import_source(path, model(6))


def test_torques_take_the_place_of_currents(tmp_path):
    require_whole(
        import_source(write(tmp_path / "rsi.log", telegrams(current="GearTorque")), model(6))[0], "torque"
    )


def test_telegrams_without_currents_or_axes_say_what_to_add(tmp_path):
    path = write(tmp_path / "rsi.log", telegrams(current=""))
    with pytest.raises(NotRecorded, match=r"neither motor currents .* present: AIPos. .*: DEF_MACur in SEND"):
        import_source(path, model(6))
    path = write(path, [line.replace("AIPos", "RIst") for line in telegrams()])
    with pytest.raises(NotRecorded, match=r"no positions of the axes \(AIPos\).*: DEF_AIPos in SEND"):
        import_source(path, model(6))


def test_commands_and_a_rail_are_read(tmp_path):
    rail = '<EIPos E1="250.0" E2="0.0"/><MECur E1="1.5" E2="0.0"/>'
    lines = [telegram(k, more=rail + f"<ASPos {attributes(ANGLES[k] + 1.0)}/>") for k in range(COUNT)]
    path = write(tmp_path / "rsi.log", lines)
    [found] = import_source(path, model(6))
    require(found, command=np.radians(ANGLES + 1.0), atol=1e-6)
    names = ["E1", "A1", "A2", "A3", "A4", "A5", "A6"]
    [found] = import_source(path, model(7), joints=names)
    np.testing.assert_allclose(found.signals["position"].values[:, 0], np.radians(250.0))
    assert "command" not in found.signals


def test_the_axes_of_a_smaller_robot_are_asked_for(tmp_path):
    path = write(tmp_path / "rsi.log", telegrams())
    with pytest.raises(RecordingError, match=r"6 axes \(A1, .*\), small has 2 joints. .* --joints A1,A2"):
        import_source(path, model(2))
    [found] = import_source(path, model(2), joints=["A2", "A3"], sign=[1, -1])
    require(found, position=np.radians(ANGLES[:, 1:3]) * [1, -1], atol=1e-6)
