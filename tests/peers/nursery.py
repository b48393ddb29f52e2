"""Starts peers: a process that has imported what they need, and forks.

    python tests/peers/nursery.py DESCRIPTOR

At each message on the socket, it forks a peer: the message is a list of script, arguments and environment,
and carries the descriptors of its input, its output, and of a pipe for its exit status. The answer is the
process id.
"""

import json
import os
import runpy
import signal
import socket
import sys
import traceback
from contextlib import suppress
from pathlib import Path

HERE = Path(__file__).parent
for name in ("can.interfaces.udp_multicast", "arm", "exidyn.drivers.host_clock"):
    with suppress(ImportError):
        __import__(name)


def become(script, arguments, environment, descriptors):
    """Run a script in this process, and end."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for place, descriptor in enumerate((descriptors[0], descriptors[1], descriptors[1])):
        os.dup2(descriptor, place)
    os.environ.update(environment)
    sys.argv = [str(HERE / script), *arguments]
    code = 1
    try:
        runpy.run_path(sys.argv[0], run_name="__main__")
        code = 0
    except SystemExit as ending:
        code = ending.code if isinstance(ending.code, int) else int(bool(ending.code))
    except BaseException:
        traceback.print_exc()
    finally:
        with suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os.write(descriptors[2], bytes([code]))
        if (shared := sys.modules.get("virtual_clock")) and shared.VARIABLE in os.environ:
            with suppress(Exception):
                shared.of_this_peer().leave()
        os._exit(code)


def bury(*_):
    """Take note of the peers that have ended."""
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def main():
    signal.signal(signal.SIGCHLD, bury)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    link = socket.socket(fileno=int(sys.argv[1]))
    while True:
        message, descriptors, *_ = socket.recv_fds(link, 1 << 16, 3)
        if not message:
            return
        if not (process := os.fork()):
            link.close()
            signal.signal(signal.SIGINT, signal.default_int_handler)
            become(*json.loads(message), descriptors)
        for descriptor in descriptors:
            os.close(descriptor)
        link.send(str(process).encode())


if __name__ == "__main__":
    main()
