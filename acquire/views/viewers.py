"""Viewers: Rerun's programs that show data in a window or to browsers, and files for later."""

import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, NamedTuple

import rerun as rr
import rerun.blueprint as rrb
import rerun_cli

from exidyn.identification.child_processes import start_program

from .live_view import LOCAL, Address, CannotShow, Targets, require_showable

MEMORY = "2GB"
"""Memory of a window, beyond which it drops the oldest data: an hour of six joints at 500 Hz. Rerun's default
is three quarters of a machine's memory, which a controller may need."""
START = 40.0
"""Maximum time until a viewer listens [s]."""
NOISE = re.compile(r"\x1b\[[0-9;]*m|os error at \S+: ")
"""Parts of Rerun's output to remove: colors and locations in its source code."""
SETTLE = 1.0
"""Time after that within which a window may still fail because there is no screen [s]."""
PATIENCE = 60.0
"""Maximum time for a viewer to receive all data [s]."""


class View(NamedTuple):
    """A view: its kind, for which viewers remember a layout, a function that logs it, and its layout."""

    kind: str
    log: Callable[[rr.RecordingStream], None]
    blueprint: rrb.Blueprint


def show(view: View, targets: Targets) -> None:
    """Show a view at all targets; a server is waited for until it ends or Ctrl-C is pressed.

    Raises:
        CannotShow: If a target cannot be opened or takes too long.
    """
    require_showable(targets)
    opened = open_targets(targets)
    try:
        _log(view, opened)
        if opened.server is not None:
            print(f"view: {opened.page} (Ctrl-C ends it)", file=sys.stderr, flush=True)
            opened.server.wait()
    except KeyboardInterrupt:
        pass  # the usual way to end it
    finally:
        if opened.server is not None:
            opened.server.terminate()
            opened.server.wait()


def _log(view: View, opened: "Opened") -> None:
    recording = rr.RecordingStream(f"exidyn_{view.kind}")
    recording.set_sinks(*opened.sinks, default_blueprint=view.blueprint)
    view.log(recording)
    try:
        recording.flush(timeout_sec=PATIENCE)
    except RuntimeError as error:
        raise CannotShow(
            f"the viewer did not receive all data within {PATIENCE:.0f} s: {error}. "
            "On a busy machine, or one without a screen, try --save FILE"
        ) from error
    recording.disconnect()  # writes the footer of a file, without which readers warn


class Opened(NamedTuple):
    """Open targets: their sinks, the server of pages if any, and the URL to open in a browser."""

    sinks: list[rr.GrpcSink | rr.FileSink]
    server: "subprocess.Popen[bytes] | None" = None
    page: str = ""


def open_targets(targets: Targets) -> Opened:
    """Open the file, the window and the server of targets.

    Raises:
        OSError: If the file cannot be written.
        CannotShow: If another target cannot be opened.
    """
    opened = Opened([])
    if targets.save is not None:
        targets.save.open("wb").close()  # its error is clearer than Rerun's
        opened.sinks.append(rr.FileSink(str(targets.save)))
    if targets.view:
        opened.sinks.append(rr.GrpcSink(open_window()))
    if targets.serve is not None:
        address = Address.read(targets.serve)
        opened = opened._replace(server=_serve(address), page=address.page)
        opened.sinks.append(rr.GrpcSink(address.local))
    return opened


def open_window() -> str:
    """Open Rerun's viewer, which outlives this process; return the URL that accepts data.

    Raises:
        CannotShow: If it does not open.
    """
    with socket.create_server((LOCAL, 0)) as probe:  # finds a free port
        port = int(probe.getsockname()[1])
    options = ["--bind", LOCAL, "--port", str(port), "--memory-limit", MEMORY, "--hide-welcome-screen"]
    try:
        _start_program("the viewer", options, [(LOCAL, port)], lives_on=True)
    except CannotShow as error:
        raise CannotShow(f"{error}. Without a screen, try --serve (in a browser) or --save FILE") from error
    return f"rerun+http://{LOCAL}:{port}/proxy"


def _serve(address: Address) -> "subprocess.Popen[bytes]":
    """Serve pages that show the data sent to `address.local`, until this process or the server ends.

    Rerun can also serve from within a process, but would then listen on all addresses of the machine.
    """
    ports = (address.port, address.port + 1)
    for port in ports:
        _require_free(address.host, port)
    options = ["--serve-web", "--bind", address.host]
    options += ["--web-viewer-port", str(ports[0]), "--port", str(ports[1])]
    if address.host != LOCAL:
        options += ["--cors-allow-origin", f"http://{address.seen}:{address.port}"]
    listens = [(address.host, port) for port in ports]
    return _start_program(f"--serve {address.host}:{address.port}", options, listens)


def end_servers() -> None:
    """End the servers started by `_serve`, which are in this process's group; it ignores the signal."""
    if os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGTERM)


def _require_free(host: str, port: int) -> None:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        socket.create_server((host, port), family=family).close()
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise CannotShow(
            f"--serve: cannot listen on port {port} of {host}: {reason}. Try another, such as {LOCAL}:9190"
        ) from error


def _start_program(
    name: str, options: Sequence[str], listens: Sequence[tuple[str, int]], lives_on: bool = False
) -> "subprocess.Popen[bytes]":
    """Start Rerun's program with some options, and wait until it listens."""
    with tempfile.TemporaryFile() as output:
        process = start_program([str(_rerun_program()), *options], output, lives_on)
        deadline = time.monotonic() + START
        while not all(_listening(host, port) for host, port in listens):
            if process.poll() is not None or time.monotonic() > deadline:
                raise CannotShow(f"{name} does not start: {_last_line(output)}")
            time.sleep(0.05)
        if lives_on:
            with suppress(subprocess.TimeoutExpired):
                process.wait(SETTLE)
                raise CannotShow(f"{name} does not start: {_last_line(output)}")
    return process


def _rerun_program() -> Path:
    """Path of Rerun's program; `python -m rerun_cli` would start it as a child that outlives this process."""
    if path := os.environ.get("RERUN_CLI_PATH"):
        return Path(path)
    folder = Path(rerun_cli.__file__).parent
    bundled = folder / "Rerun.app" / "Contents" / "MacOS" / "Rerun"
    return bundled if bundled.exists() else folder / ("rerun.exe" if sys.platform == "win32" else "rerun")


def _listening(host: str, port: int) -> bool:
    address = {"0.0.0.0": LOCAL, "::": "::1"}.get(host, host)
    try:
        socket.create_connection((address, port), timeout=1.0).close()
    except OSError:
        return False
    return True


def _last_line(output: IO[bytes]) -> str:
    output.seek(0)
    lines = NOISE.sub("", output.read().decode(errors="replace")).split("\n")
    return next((line.strip().rstrip(".") for line in reversed(lines) if line.strip()), "it prints nothing")
