"""Commands on a peer: its controller file, and their output as JSON."""

import json
from contextlib import contextmanager

from exidyn.acquire.command_line import main
from exidyn.acquire.run.stopping.watch import WatchLimits

from ...peers.driver_peers import REAL, peer_of
from ...peers.driver_peers.kuka_rsi import POSE as POSE

PATIENT = WatchLimits(silence=2.0, stall=2.0, missed=0.9, stale=1.0)
"""Monitors that do not mind a computer which is busy with other things; all others are as usual."""


def controller_file(folder, driver, settings):
    """Written; its path."""
    lines = [f'driver = "{driver}"', "[settings]", *(f"{k} = {json.dumps(v)}" for k, v in settings.items())]
    path = folder / f"{driver}.toml"
    path.write_text("\n".join(lines))
    return path


def cell(name):
    """Of a driver, as a context manager: the peer with a cobot, and the path of its controller file."""
    peer = peer_of(name)

    @contextmanager
    def running(folder, **settings):
        with peer.running(folder, *peer.cobot) as (process, given):
            yield process, controller_file(folder, name, given | peer.patient | settings)

    return running


CELLS = {name: cell(name) for name in REAL if peer_of(name).cobot}
"""Of drivers whose peer can be a cobot."""


def verdicts(text):
    """Name -> verdict of the judgements of a jog."""
    return {one["name"]: one["verdict"] for one in text["judgements"]}


def jog(capsys, *arguments):
    """Exit code, and the output of a jog of the cobot."""
    code = main(["jog", "--robot", "cobot", "--json", "-", *map(str, arguments)])
    return code, json.loads(capsys.readouterr().out)


def jog_on(name, folder, capsys, *arguments, **settings):
    """As `jog`, on the peer of a driver, which is given as well."""
    with CELLS[name](folder, **settings) as (peer, path):
        code, text = jog(capsys, "--controller", path, "--yes", *arguments)
    return code, text, peer
