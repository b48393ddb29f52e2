"""The live view of a run: what it saves, shows in a window and serves, and how it dies without harm."""

import io
import os
import signal
import socket
import struct
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import rerun_cli
from PIL import Image
from rerun.experimental import ViewerClient

from exidyn.acquire.run.frames import EVENT, HEAD, SAMPLE, Cycle, text_frame
from exidyn.acquire.run.pipe import SinkFailed
from exidyn.acquire.run.recorder import RunHead
from exidyn.acquire.views import view_process
from exidyn.acquire.views.live_log import finite_limits, usual_cycle
from exidyn.acquire.views.live_view import CannotShow, Targets, start_view
from exidyn.acquire.views.parts import COLORS, COLUMNS, RED
from exidyn.acquire.views.view_process import ABANDONED
from exidyn.acquire.views.viewers import open_window
from exidyn.identification.arm.newton_euler import link_frames
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.pages.browser import free_port, headless_browser, wait_for
from ...parts.pages.live_frames import frames, measured
from ...parts.pages.rerun_viewer import numbers, read, require_all, require_poses, seconds, settled
from ...parts.small import two_joints
from ...parts.system_needs import VULKAN

pytestmark = pytest.mark.clocked(patient=True)

VIEWER = Path(rerun_cli.__file__).with_name("rerun")
SECONDS = 3.0
VIEWS = 8


@pytest.fixture(scope="module")
def model():
    return read_model("cobot")


@pytest.fixture(scope="module")
def run(model):
    """Frames of a run."""
    return [frame for _, frame in frames(model, SECONDS)]


@contextmanager
def view(**targets):
    """A view, closed in the end."""
    (shown,) = start_view(Targets(**targets))
    with shown:
        yield shown


def hand_over(shown, run):
    """All frames, ten times as fast as they would come."""
    for count, frame in enumerate(run):
        shown.put(frame)
        if count % 50 == 0:
            time.sleep(0.01)


class Source:
    """Frames that come in two pieces and end."""

    def __init__(self, run):
        self.pieces = [run[: len(run) // 2], run[len(run) // 2 :]]

    @property
    def ended(self):
        return not self.pieces

    def read(self, patience):
        return [(frame[:1], frame[5:]) for frame in self.pieces.pop(0)]


def drawn(path, run):
    """What the process of a view draws, in this process."""
    recording, _ = view_process._start(Targets(save=path))
    view_process._show(Source(run), view_process.RunFrames(recording), 0.0)
    view_process._finish(recording)
    return read(path)


@pytest.fixture(scope="module")
def file(run, tmp_path_factory):
    """What a view saves of the run, in a process of its own."""
    path = tmp_path_factory.mktemp("live") / "run.rrd"
    with view(save=path) as shown:
        hand_over(shown, run)
    assert not shown.failure
    assert not shown.dropped
    return path


@pytest.fixture(scope="module")
def chunks(file):
    return read(file)


def listeners(port):
    """Addresses at which anybody listens on a port, as the kernel writes them."""
    found = []
    tables = [Path("/proc/net/tcp"), Path("/proc/net/tcp6")]
    for table in filter(Path.exists, tables):  # without IPv6 in the kernel, only the first
        for line in table.read_text().splitlines()[1:]:
            local, state = line.split()[1], line.split()[3]
            if state == "0A" and int(local.split(":")[1], 16) == port:
                found.append(local.split(":")[0])
    return found


LOOPBACK = "0100007F"


def test_nothing_asked_for_starts_nothing():
    assert start_view(Targets()) == []


def test_saved_run_is_the_run(chunks, model):
    motion, position, current = measured(model, SECONDS)
    np.testing.assert_array_equal(numbers(chunks, "/position/measured").reshape(-1, 6), position)
    np.testing.assert_array_equal(numbers(chunks, "/current/measured").reshape(-1, 6), current)
    np.testing.assert_allclose(seconds(chunks, "/position/measured"), motion.time, atol=2e-9)
    command = numbers(chunks, "/position/commanded").reshape(-1, 6)
    np.testing.assert_array_equal(command[300:-2], motion.position[302:])
    assert np.isnan(command[:250]).all()
    error = numbers(chunks, "/tracking_error").reshape(-1, 6)
    np.testing.assert_allclose(error[300:], 1e3 * (command - position)[300:], atol=1e-9)


def test_residual_is_noise_and_velocity_that_of_the_motion(chunks, model):
    motion, _, current = measured(model, SECONDS)
    at = np.searchsorted(motion.time, seconds(chunks, "/residual") - 1e-6)
    assert len(at) > 40 * SECONDS
    velocity = numbers(chunks, "/velocity/measured").reshape(-1, 6)
    np.testing.assert_allclose(velocity, motion.velocity[at], atol=0.005)
    usual = np.sqrt(np.mean((current * model.robot.drive_gain) ** 2, axis=0))
    assert np.all(np.std(numbers(chunks, "/residual").reshape(-1, 6), axis=0) < 0.01 * usual)


def test_lateness_and_skipped_cycles_are_shown_as_time(chunks):
    skipped = numbers(chunks, "/lateness/skipped")
    np.testing.assert_allclose(skipped, [4.0, 2.0])
    late = numbers(chunks, "/lateness/late")
    assert len(late) == 500 * SECONDS
    assert late.max() == pytest.approx(1.3)


def test_events_come_in_words_and_a_stop_in_red(chunks):
    (stop,) = chunks["/events/stop", "TextLog:text"][0].to_pylist()[0]
    assert stop.endswith("stop: joint2: tracking error 0.041 rad, limit 0.035")
    (colour,) = chunks["/events/stop", "TextLog:color"][0].to_pylist()[0]
    assert colour >> 8 == (RED[0] << 16) + (RED[1] << 8) + RED[2]
    assert chunks["/events/stop", "TextLog:level"][0].to_pylist()[0] == ["CRITICAL"]
    stages = [text for array in chunks["/events/stage", "TextLog:text"] for (text,) in array.to_pylist()]
    assert [text.split()[-1] for text in stages] == ["listening", "running", "braking"]
    assert ("/events/stage", "TextLog:color") not in chunks


def texts(chunks, kind):
    return [text for array in chunks[f"/events/{kind}", "TextLog:text"] for (text,) in array.to_pylist()]


def test_run_that_ends_at_once_is_shown_with_its_reason(run, tmp_path):
    chunks = drawn(tmp_path / "run.rrd", [*run[:6], *run[-3:]])
    assert numbers(chunks, "/position/measured").shape == (6 * 4,)
    assert texts(chunks, "stop")[0].endswith("limit 0.035")
    assert texts(chunks, "end") == ["0.01 s  end: stopped (tracking)"]


def test_an_unended_run_is_reported_as_abandoned(run, tmp_path):
    chunks = drawn(tmp_path / "run.rrd", run[:100])
    lines = texts(chunks, "stop")
    assert " ".join(line.strip() for line in lines) == f"0.19 s  stop: {ABANDONED}"
    assert len(lines) > 1
    assert max(map(len, lines)) <= COLUMNS


def spoiled(run):
    """Among the frames of a run, some that make no sense: cut, of another arm, of no joints, not JSON."""
    other = frames(two_joints.model(), 0.1)
    yield run[0]
    yield struct.pack("<cI", EVENT, 4) + b"none"
    yield text_frame(EVENT, {"host_time": "late"})
    yield from (frame for _, frame in other if frame[:1] in (HEAD, SAMPLE))
    yield struct.pack("<cI", SAMPLE, 5) + b"short"
    yield struct.pack("<cI", SAMPLE, 32) + bytes(32)
    yield text_frame(HEAD, {})
    yield from run[1:]


def test_frames_that_make_no_sense_are_not_shown(model, run, tmp_path):
    chunks = drawn(tmp_path / "run.rrd", list(spoiled(run)))
    _, position, _ = measured(model, SECONDS)
    np.testing.assert_array_equal(numbers(chunks, "/position/measured").reshape(-1, 6), position)


def test_cycle_is_learnt_though_most_of_the_first_were_skipped():
    cycles = [
        Cycle(round(2e6 * at), 0, 0.0, skipped, 0, np.empty((7, 0)))
        for at, skipped in ((0, 0), (2, 1), (3, 0), (6, 2), (8, 1))
    ]
    assert usual_cycle(cycles) == pytest.approx(0.002)
    assert usual_cycle(cycles[:1]) > 0.0


def test_finite_limits_are_drawn_in_the_colour_of_their_joint(chunks, model):
    limits = model.robot.limits
    drawn = numbers(chunks, "/position/limit").reshape(-1, 12)
    np.testing.assert_array_equal(drawn[0], np.concatenate([limits.position_lower, limits.position_upper]))
    current = numbers(chunks, "/current/limit").reshape(-1, 12)
    np.testing.assert_allclose(current[0, 6:], limits.torque / np.abs(model.robot.drive_gain))
    (colours,) = chunks["/position/limit", "SeriesLines:colors"][0].to_pylist()
    red, green, blue = COLORS[2]
    assert colours[2] >> 8 == colours[8] >> 8 == (red << 16) + (green << 8) + blue
    assert seconds(chunks, "/velocity/limit")[-1] > SECONDS - 0.5


def test_limits_not_given_are_not_drawn(model):
    robot = read_model("cobot").robot
    robot.limits.position_upper[1] = np.inf
    robot.limits.torque[:] = np.inf
    found = finite_limits(robot, "current")
    assert "current" not in found
    np.testing.assert_array_equal(found["position"].joints, [0, 1, 2, 3, 4, 5, 0, 2, 3, 4, 5])


def test_arm_moves_as_measured(chunks, model):
    _, position, _ = measured(model, SECONDS)
    at = np.rint(seconds(chunks, "/arm/moves") * 500).astype(int).reshape(-1, 6)[:, 0]
    assert len(at) > 45 * SECONDS
    require_poses(chunks, "/arm/moves", model.robot.kinematics, position[at])
    (first,) = chunks["/arm/moves", "Transform3D:child_frame"][0].to_pylist()[0]
    assert first == f"arm/{link_frames(model.robot.kinematics)[0].child}"


def test_saved_file_is_whole(file):
    subprocess.run([VIEWER, "rrd", "verify", file], check=True, capture_output=True)


def test_run_of_a_controller_that_gives_torque_shows_torque(model, tmp_path):
    head = RunHead("torque", model, signals=("position", "torque"), epoch=0).frame()
    found = drawn(tmp_path / "run.rrd", [f for _, f in frames(model, 0.5, explained=head)])
    assert ("/torque/limit", "Scalars:scalars") in found
    assert not any(entity.startswith("/current") for entity, _ in found)


def test_killed_view_takes_nothing_along(model, run, tmp_path, capsys):
    port, path = free_port(), tmp_path / "run.rrd"
    with view(save=path, serve=f"127.0.0.1:{port}") as shown:
        hand_over(shown, run[: len(run) // 2])
        assert wait_for(lambda: path.stat().st_size > 300_000)  # more than what stands still
        os.kill(shown.process_id, signal.SIGKILL)
        hand_over(shown, run[len(run) // 2 :])
        assert "ended" in shown.failure
    assert "warning: live view: its process" in capsys.readouterr().err
    assert wait_for(lambda: not listeners(port) and not listeners(port + 1), 10.0)
    assert len(numbers(read_part(path), "/position/measured"))


def test_view_that_is_too_slow_is_not_waited_for_and_reports_what_it_lacks(run, tmp_path, capsys):
    handed = [run[0], *10 * run[1:-4], *run[-4:]]
    with view(save=tmp_path / "run.rrd") as shown:
        os.kill(shown.process_id, signal.SIGSTOP)
        for frame in handed:
            shown.put(frame)
        os.kill(shown.process_id, signal.SIGCONT)
        assert not shown.failure
    found = read(tmp_path / "run.rrd")
    assert texts(found, "stop")[0].endswith("limit 0.035")
    assert len(texts(found, "end")) == 1
    samples = sum(frame[:1] == SAMPLE for frame in handed)
    assert 0 < shown.dropped == samples - len(seconds(found, "/position/measured"))
    assert f"too slow for {shown.dropped} cycles" in capsys.readouterr().err


def test_rerun_that_is_not_installed_is_reported(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(CannotShow, match="pip install rerun-sdk"):
        start_view(Targets(save=tmp_path / "run.rrd"))
    assert start_view(Targets()) == []


def read_part(path):
    with pytest.warns(match="footer"):
        return read(path)


def test_pages_and_data_are_served_on_this_machine_only(capsys):
    port = free_port()
    with view(serve=f"127.0.0.1:{port}") as shown:
        assert listeners(port) == [LOOPBACK]
        assert listeners(port + 1) == [LOOPBACK]
        address = shown.message.split()[-1]
        assert address in capsys.readouterr().err
        with urllib.request.urlopen(address) as page:
            assert b"Rerun" in page.read()
    assert wait_for(lambda: not listeners(port) and not listeners(port + 1), 10.0)


@pytest.mark.parametrize(
    "text",
    ["", "here and there", "127.0.0.1:port", "127.0.0.1:99999", "127.0.0.1:65535", "127.0.0.1:0", "a/b"],
)
def test_address_that_is_none_is_refused(text):
    with pytest.raises(CannotShow, match=r"127\.0\.0\.1:9090"):
        start_view(Targets(serve=text))


def test_port_that_is_taken_is_reported():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(SinkFailed, match=f"port {port} of 127.0.0.1"):
            start_view(Targets(serve=f"127.0.0.1:{port}"))


def test_file_that_cannot_be_written_is_reported(tmp_path):
    with pytest.raises(CannotShow, match="no folder"):
        start_view(Targets(save=tmp_path / "nowhere" / "run.rrd"))
    with pytest.raises(CannotShow, match="directory"):
        view_process._start(Targets(save=tmp_path))


@contextmanager
def window(folder, monkeypatch):
    """Let windows open where there is no screen; in the end, none is left."""
    VULKAN.require()
    program, note = folder / "viewer", folder / "started"
    program.write_text(
        f'#!/bin/sh\necho $$ "$@" >> {note}\nexec {VIEWER} --headless --window-size 1600x900 "$@"\n'
    )
    program.chmod(0o755)
    monkeypatch.setenv("RERUN_CLI_PATH", str(program))
    try:
        yield lambda: [line.split() for line in note.read_text().splitlines()]
    finally:
        for process, *_ in (line.split() for line in note.read_text().splitlines()):
            try:
                os.kill(int(process), signal.SIGKILL)
            except ProcessLookupError:
                pass


def port_of(words):
    return int(words[words.index("--port") + 1])


def test_window_shows_every_view_without_complaint_and_lives_on(run, tmp_path, monkeypatch):
    with window(tmp_path, monkeypatch) as started:
        with view(view=True) as shown:
            ((process, *words),) = started()
            assert listeners(port_of(words)) == [LOOPBACK]
            hand_over(shown, run)
        assert not shown.failure
        client = ViewerClient.connect(f"rerun+http://127.0.0.1:{port_of(words)}/proxy")
        end = SECONDS - 0.002
        state = settled(client, end, VIEWS)
        picture = client.take_screenshot()
    require_all(state, end, VIEWS)
    assert all(count > 100 for count in coloured(picture)[:6])


def test_a_viewer_that_does_not_start_is_one_sentence(tmp_path, monkeypatch):
    program = tmp_path / "viewer"
    program.write_text("#!/bin/sh\necho 'Error: neither WAYLAND_DISPLAY nor DISPLAY is set.'\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setenv("RERUN_CLI_PATH", str(program))
    with pytest.raises(CannotShow, match=r"DISPLAY is set\. Without a screen, try --serve"):
        open_window()


def test_killed_window_takes_nothing_along(run, tmp_path, monkeypatch):
    with window(tmp_path, monkeypatch) as started, view(view=True, save=tmp_path / "run.rrd") as shown:
        hand_over(shown, run[: len(run) // 2])
        ((process, *_),) = started()
        os.kill(int(process), signal.SIGKILL)
        hand_over(shown, run[len(run) // 2 :])
        shown.close()
        assert not shown.failure
    assert len(numbers(read(tmp_path / "run.rrd"), "/position/measured")) == 6 * 500 * SECONDS


def coloured(picture):
    """How many pixels of a picture have the colour of each joint, or nearly."""
    pixels = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(int)
    return [int(np.sum(np.abs(pixels - colour).max(axis=2) < 12)) for colour in COLORS]


def test_browser_shows_the_run(tmp_path):
    model, port, pictures = two_joints.model(), free_port(), []
    beginning = [frame for due, frame in frames(model, SECONDS) if due < 0.8]
    with headless_browser(tmp_path / "profile") as browser, view(serve=f"127.0.0.1:{port}") as shown:
        browser.open(shown.message.split()[-1] + "&renderer=webgl", width=1000, height=640)
        hand_over(shown, beginning)

        def is_drawn():
            pictures.append(browser.picture())
            return all(count > 100 for count in coloured(pictures[-1])[:2])

        assert wait_for(is_drawn, 150.0)
