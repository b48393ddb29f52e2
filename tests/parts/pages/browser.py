"""A headless Chromium, driven through a pipe; ports for the pages that it shows."""

import base64
import json
import os
import signal
import socket
import subprocess
import time
from contextlib import contextmanager

from ..system_needs import BASH, BROWSER, browser

FLAGS = (
    "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--disable-dev-shm-usage", "--remote-debugging-pipe",
)  # fmt: skip


class Refused(Exception):
    """The browser answers a command with an error."""


class Browser:
    """One page of it."""

    def __init__(self, to, back):
        self._to, self._back, self._number, self._rest, self._session = to, back, 0, b"", None

    def open(self, address, width=1600, height=900):
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )
        self.call("Page.navigate", url=address)

    def picture(self, seconds=60.0):
        """PNG of what the page shows. While a page is replaced by the next one there is none: asked again."""
        end = time.monotonic() + seconds
        while True:
            try:
                return base64.b64decode(self.call("Page.captureScreenshot")["data"])
            except Refused:
                if time.monotonic() > end:
                    raise
                time.sleep(0.2)

    def call(self, method, **parameters):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = json.loads(self._line())
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise Refused(f"{method}: {answer['error']}")
                return answer["result"]

    def _line(self):
        while b"\0" not in self._rest:
            data = os.read(self._back, 1 << 20)
            assert data, "the browser has ended"
            self._rest += data
        line, _, self._rest = self._rest.partition(b"\0")
        return line


@contextmanager
def headless_browser(folder):
    """A browser without a window; its profile lies in the folder."""
    BROWSER.require()
    BASH.require()
    to_browser, from_us = os.pipe()
    from_browser, to_us = os.pipe()
    # the browser reads from file 3 and writes to file 4
    command = ["bash", "-c", f'exec "$@" 3<&{to_browser} 4>&{to_us}', "bash"]
    process = subprocess.Popen(
        [*command, browser(), *FLAGS, f"--user-data-dir={folder}"],
        pass_fds=(to_browser, to_us),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    os.close(to_browser)
    os.close(to_us)
    try:
        yield Browser(from_us, from_browser)
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        os.close(from_us)
        os.close(from_browser)


def wait_for(happens, seconds=60.0):
    """Whatever is true in the end, or the last that was not."""
    end = time.monotonic() + seconds
    while not (found := happens()) and time.monotonic() < end:
        time.sleep(0.1)
    return found


def free_port():
    """A port that is free just now, as is the next one."""
    while True:
        with socket.create_server(("127.0.0.1", 0)) as first:
            port = first.getsockname()[1]
            try:
                socket.create_server(("127.0.0.1", port + 1)).close()
                return port
            except OSError:
                continue
