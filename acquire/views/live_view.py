"""Where a view is shown; and the process that shows a run, which may die: the run goes on."""

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

from ..run.errors import RunError
from ..run.pipe import PipeSink

LOCAL, PORT = "127.0.0.1", 9090
"""What only this machine reaches."""
LAST_PORT = 65535
"""No page can be served there, since its data come from the next one."""
PROCESS = "exidyn.acquire.views.view_process"
FINISH = 10.0
"""How long the last frames may take to be shown [s]; there is no longer wait for a viewer that hangs."""


class CannotShow(RunError):
    """A run cannot be shown as asked."""


class Address(NamedTuple):
    """Where a server listens.

    Attributes:
        host: An address of this machine; "0.0.0.0" or "::" for all of them.
        port: Port of the page; the data come from the next one.
    """

    host: str
    port: int

    @classmethod
    def read(cls, text: str) -> "Address":
        """From ADDRESS:PORT; without a port, `PORT`.

        Raises:
            CannotShow: It is no such thing.
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
        """How a browser calls the host: by name, where it listens on all addresses."""
        host = socket.gethostname() if self.host in ("0.0.0.0", "::") else self.host
        return f"[{host}]" if ":" in host else host

    @property
    def local(self) -> str:
        """Where this machine sends the data."""
        here = {"0.0.0.0": LOCAL, "::": "[::1]"}.get(self.host)
        return f"rerun+http://{here or self.seen}:{self.port + 1}/proxy"

    @property
    def data(self) -> str:
        """Where a browser finds the data."""
        return f"rerun+http://{self.seen}:{self.port + 1}/proxy"

    @property
    def page(self) -> str:
        """What to open in a browser."""
        return f"http://{self.seen}:{self.port}/?url={quote(self.data, safe='')}"


@dataclass(frozen=True)
class Targets:
    """Where a run is shown: any of these at once.

    Attributes:
        view: Whether in Rerun's viewer, which lives on after the run.
        serve: ADDRESS:PORT at which browsers find it, as long as the run goes on; None for nowhere.
        save: File that Rerun's viewer opens later; None for none.
    """

    view: bool = False
    serve: str | None = None
    save: Path | None = None

    @property
    def any(self) -> bool:
        """Whether the run is shown anywhere."""
        return self.view or self.serve is not None or self.save is not None

    def text(self) -> str:
        """For the process that shows it."""
        return json.dumps([self.view, self.serve, str(self.save) if self.save else None])

    @classmethod
    def read(cls, text: str) -> "Targets":
        """The inverse of `text`."""
        view, serve, save = json.loads(text)
        return cls(view, serve, Path(save) if save else None)


def start_view(targets: Targets) -> "list[LiveView]":
    """Start the view of a run, ready for its frames, and print where it is; none if there is no target.

    Raises:
        CannotShow: See `require_showable`.
        SinkFailed: A viewer or a server does not start.
    """
    require_showable(targets)
    if not targets.any:
        return []
    view = LiveView(targets)
    if view.message:
        print(view.message, file=sys.stderr)
    return [view]


def require_showable(targets: Targets) -> None:
    """Raise where it is plain that a run cannot be shown.

    Raises:
        CannotShow: The address is none, the file's folder is not there, or Rerun is not.
    """
    if targets.serve is not None:
        Address.read(targets.serve)
    if targets.save is not None and not targets.save.absolute().parent.is_dir():
        raise CannotShow(f"--save {targets.save}: there is no folder {targets.save.absolute().parent}")
    if targets.any and find_spec("rerun") is None:
        raise CannotShow("view: Rerun is not installed. Try pip install rerun-sdk, or go without the view")


class LiveView(PipeSink):
    """The view of a run, at one target at least: a sink that drops what it is too slow for."""

    def __init__(self, targets: Targets) -> None:
        self._began = False
        super().__init__("live view", PROCESS, [targets.text()], lossy=True)
        self._began = True

    def close(self, patience: float = FINISH) -> None:
        """Wait until the last frames are shown; what a view that was killed has left behind ends too."""
        super().close(patience)
        lacks = [self.failure] if self.failure else []
        if self.dropped:
            lacks.append(f"it was too slow for {self.dropped} cycles and events, which it does not show")
        for text in lacks if self._began else ():
            print(f"exidyn: warning: live view: {text}; the recording does not depend on it", file=sys.stderr)
        self._began = False
        try:
            os.killpg(self.process_id, signal.SIGTERM)
        except (ProcessLookupError, PermissionError):
            pass  # nothing is left
