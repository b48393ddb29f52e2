"""Targets of a view, and the process that shows a run; if it dies, the run continues."""

import json
import os
import signal
import socket
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from ipaddress import ip_address
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote, urlsplit

from ..arguments.command import Option
from ..run.errors import RunError
from ..run.pipe import PipeSink

LOCAL, PORT = "127.0.0.1", 9090
"""Default address, which only this machine can reach, and default port."""
LAST_PORT = 65535
"""Highest port; it cannot serve a page, since the data come from the next port."""
PROCESS, CONTACT_PROCESS = (f"exidyn.acquire.views.{name}" for name in ("view_process", "contact_view"))
"""Modules of the processes that show a run, and external torques."""
SERVE = Option(
    "--serve [ADDRESS:PORT]",
    f"serve the view to browsers; default: {LOCAL}:{PORT}, this machine only",
    alone=f"{LOCAL}:{PORT}",
)
SAVE = Option("--save FILE", "save the view as a file (.rrd)", Path)
VIEW = (Option("--view", "show it live in Rerun's viewer"), SERVE, SAVE)
"""Options of a live view."""
FINISH = 10.0
"""Maximum time to show the last frames [s], in case a viewer hangs."""


class CannotShow(RunError):
    """A run cannot be shown as requested."""


class Address(NamedTuple):
    """Address of a server."""

    host: str  # address of this machine; "0.0.0.0" or "::" for all of its addresses
    port: int  # port of the page; the data come from the next port

    @classmethod
    def read(cls, text: str) -> "Address":
        """Parse ADDRESS:PORT; the default port is `PORT`.

        Raises:
            CannotShow: If the text is not an address.
        """
        try:
            parts = urlsplit(f"//{text}")
            host = ip_address(LOCAL if parts.hostname == "localhost" else parts.hostname or "")
            port = PORT if parts.port is None else parts.port
            if not 0 < port < LAST_PORT:
                raise ValueError(f"port {port} is not between 1 and {LAST_PORT - 1}")
        except ValueError as error:
            raise CannotShow(
                f"--serve {text}: {error}. Give an address of this machine and a port, such as {LOCAL}:{PORT}"
            ) from error
        return cls(str(host), port)

    @property
    def seen(self) -> str:
        """Host in URLs: the name of this machine if the server listens on all addresses."""
        host = socket.gethostname() if self.host in ("0.0.0.0", "::") else self.host
        return f"[{host}]" if ":" in host else host

    @property
    def local(self) -> str:
        """URL to which this machine sends the data."""
        host = {"0.0.0.0": LOCAL, "::": "[::1]"}.get(self.host)
        return f"rerun+http://{host or self.seen}:{self.port + 1}/proxy"

    @property
    def page(self) -> str:
        """URL of the page, with the URL from which a browser gets the data."""
        data = f"rerun+http://{self.seen}:{self.port + 1}/proxy"
        return f"http://{self.seen}:{self.port}/?url={quote(data, safe='')}"


@dataclass(frozen=True)
class Targets:
    """Targets of a view; any number of them at once."""

    view: bool = False  # whether to show it in Rerun's viewer, which stays open afterward
    serve: str | None = None  # ADDRESS:PORT of a page for browsers, available during the run, or None
    save: Path | None = None  # file that Rerun's viewer can open later, or None

    @property
    def any(self) -> bool:
        """Whether there is any target."""
        return self.view or self.serve is not None or self.save is not None

    def text(self) -> str:
        """Serialized targets, an argument of the process that shows the run."""
        return json.dumps([self.view, self.serve, str(self.save) if self.save else None])

    @classmethod
    def read(cls, text: str) -> "Targets":
        """The inverse of `text`."""
        view, serve, save = json.loads(text)
        return cls(view, serve, Path(save) if save else None)


def start_view(targets: Targets, process: str = PROCESS) -> "list[LiveView]":
    """Start the view of a run by a module, and print its address; returns an empty list without a target.

    Raises:
        CannotShow: See `require_showable`.
        SinkFailed: If a viewer or a server does not start.
    """
    require_showable(targets)
    if not targets.any:
        return []
    view = LiveView(targets, process)
    if view.message:
        print(view.message, file=sys.stderr)
    return [view]


def require_showable(targets: Targets) -> None:
    """Raise if a run obviously cannot be shown.

    Raises:
        CannotShow: If the address is invalid, the file's folder does not exist, or Rerun is not installed.
    """
    if targets.serve is not None:
        Address.read(targets.serve)
    if targets.save is not None and not targets.save.absolute().parent.is_dir():
        raise CannotShow(f"--save {targets.save}: there is no folder {targets.save.absolute().parent}")
    if targets.any and find_spec("rerun") is None:
        raise CannotShow("view: Rerun is not installed. Try pip install rerun-sdk, or omit the view")


class LiveView(PipeSink):
    """The view of a run with at least one target: a sink that drops samples if it is too slow."""

    def __init__(self, targets: Targets, process: str = PROCESS) -> None:
        self._began = False
        super().__init__("live view", process, [targets.text()], lossy=True)
        self._began = True

    def close(self, patience: float = FINISH) -> None:
        """Wait until the last frames are shown, and end processes that a killed view has left behind."""
        super().close(patience)
        problems = [self.failure] if self.failure else []
        if self.dropped:
            problems.append(f"it was too slow for {self.dropped} cycles and events, which it does not show")
        for text in problems if self._began else ():
            print(f"exidyn: warning: live view: {text}; nothing else is affected", file=sys.stderr)
        self._began = False
        try:
            os.killpg(self.process_id, signal.SIGTERM)
        except (ProcessLookupError, PermissionError):
            pass  # no process is left
