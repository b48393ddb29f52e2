"""Rerun recordings read back, and a viewer without a window that draws them."""

import socket
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import rerun.chunk
from rerun.experimental import ViewerClient

from exidyn.acquire.views import viewers
from exidyn.acquire.views.live_view import Targets
from exidyn.identification.arm.newton_euler import link_poses

from ..system_needs import VULKAN


def read(path):
    """Columns of every entity: (entity path without escapes, column) -> arrow arrays."""
    found = {}
    for chunk in rerun.chunk.RrdReader(path).stream():
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            entity = str(chunk.entity_path).replace("\\", "")
            found.setdefault((entity, name), []).append(batch[name])
    return found


def numbers(chunks, entity, column="Scalars:scalars"):
    arrays = chunks[entity, column]
    return np.concatenate([array.flatten().to_numpy(zero_copy_only=False) for array in arrays])


def seconds(chunks, entity):
    return np.concatenate([array.cast("int64").to_numpy() for array in chunks[entity, "time"]]) * 1e-9


def numbers_nested(chunks, entity, column, width):
    parts = [array.flatten().flatten().to_numpy(zero_copy_only=False) for array in chunks[entity, column]]
    return np.concatenate(parts).reshape(-1, width)


def saved(view, path):
    """Columns of a view that is saved in a file."""
    viewers.show(view, Targets(save=path))
    return read(path)


def require_poses(chunks, entity, kinematics, position):
    """The links of an arm stand as at positions (t, n)."""
    poses = link_poses(kinematics, position).reshape(-1, 7)
    place = numbers_nested(chunks, entity, "Transform3D:translation", 3)
    np.testing.assert_allclose(place, poses[:, :3], atol=1e-6)
    turn = numbers_nested(chunks, entity, "Transform3D:quaternion", 4)
    alike = np.abs(np.sum(turn * poses[:, 3:], axis=1))  # a quaternion and its negative turn alike
    np.testing.assert_allclose(alike, 1.0, atol=1e-6)


def text_of(chunks, entity):
    (text,) = chunks[entity, "TextDocument:text"][0].to_pylist()[0]
    return text


@contextmanager
def headless_viewer():
    """A viewer without a window, which draws in software if it must.

    Without a Vulkan driver it answers at first, and ends when it draws.
    """
    VULKAN.require()
    with socket.socket() as probe:  # any port that is free just now
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    program = str(Path(sys.executable).with_name("rerun"))
    client = ViewerClient.spawn(headless=True, port=port, executable_path=program, hide_welcome_screen=True)
    try:
        yield client, f"rerun+http://127.0.0.1:{port}/proxy"
    finally:
        client.quit()


def last_time(state):
    """The latest time [s] that the viewer knows of."""
    times = [line.end * 1e-9 for r in state.recordings for line in r.timelines if line.name == "time"]
    return max(times, default=-1.0)


def complaints(state):
    return [report for view in state.views for report in view.reports]


def settled(client, end, views, attempts=300):
    """State of the viewer once everything has arrived and is drawn, or the last one if it never is."""
    for _ in range(attempts):
        state = client.get_state()
        arrived = last_time(state) == pytest.approx(end, abs=1e-6)
        if arrived and len(state.views) == views and not complaints(state):
            break
        time.sleep(0.2)
    return state


def require_drawn(show, end, views, monkeypatch):
    """A picture of the window that `show` opens: all is drawn up to a time [s], in so many views."""
    with headless_viewer() as (client, address):
        monkeypatch.setattr(viewers, "open_window", lambda: address)
        show()
        state = settled(client, end, views)
        picture = client.take_screenshot()
    require_all(state, end, views)
    return picture


def require_all(state, end, views):
    assert last_time(state) == pytest.approx(end, abs=1e-6)
    assert len(state.views) == views
    assert not complaints(state)
