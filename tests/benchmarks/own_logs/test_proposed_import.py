"""What init proposes, import does, for every sample log; else init says that import refuses it, and why."""

import json
import shlex

import pytest
from parts.own_logs.foreign import foreign
from parts.own_logs.logs import public
from parts.own_logs.sets import FOLDER

from exidyn.acquire.command_line import main

pytestmark = pytest.mark.slow

FOREIGN = {log.name: log for log in foreign()}
PUBLIC = {log.name: log for log in public()}
NEEDS = {"pandas": "pandas", "h5py": "h5py", "rosbags": "rosbags", "pyarrow": "pyarrow", "LeRobot": "pyarrow"}


def require_import(log, folder, monkeypatch, capsys):
    """Init, and the command line that it ends with."""
    monkeypatch.chdir(folder)
    source, arm, _ = log.make(folder)
    if main(["init", source.name, "--robot", arm.name, "--json", "proposal.json"]):
        assert "--columns" in capsys.readouterr().err
        return
    proposal = json.loads((folder / "proposal.json").read_text())
    if proposal["then"]:
        assert main(shlex.split(proposal["then"])[1:]) == 0
    else:
        undecided = [guess["what"] for guess in proposal["guesses"] if not guess["decided"]]
        assert proposal["refusal"] or undecided


@pytest.mark.parametrize("name", FOREIGN)
def test_logs_of_other_libraries(name, tmp_path, monkeypatch, capsys):
    for word, package in NEEDS.items():
        if word in name:
            pytest.importorskip(package)
    if not FOLDER.is_dir():
        pytest.skip(f"no real recordings in {FOLDER}; set EXIDYN_DATA")
    require_import(FOREIGN[name], tmp_path, monkeypatch, capsys)


@pytest.mark.skipif(not PUBLIC, reason=f"no real recordings in {FOLDER}; set EXIDYN_DATA")
@pytest.mark.parametrize("name", PUBLIC)
def test_public_data_sets(name, tmp_path, monkeypatch, capsys):
    require_import(PUBLIC[name], tmp_path, monkeypatch, capsys)
