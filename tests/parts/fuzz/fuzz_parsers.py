"""Every parser with valid files for it: what is damaged, how, and how it is read."""

import gzip
import json
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from exidyn.acquire.arguments.run_options import read_controller
from exidyn.acquire.commands.view_command import view_of
from exidyn.acquire.files.result_files import read_shown
from exidyn.acquire.run.arms import make_driver
from exidyn.acquire.terminal.json_output import json_text
from exidyn.acquire.terminal.recording_text import describe, recording_table
from exidyn.drivers.kuka_rsi.config import config_text, read_config, standard_config
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.mcap.mcap_records import recover
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.plans.plan_file import read_plan

from ..runs import parser_files
from ..runs.parser_files import Files
from ..small import two_joints
from . import fuzz_uses
from .fuzz_mutations import BINARY, EDITED, JSON, PACKETS, TEXT, Mutation, double, number, scaled, tree, value


class Damage(NamedTuple):
    """One file of a valid set, and what is done to it."""

    files: Files  # the set
    name: str  # of the file
    mutations: tuple[Mutation, ...]  # to choose from
    finish: Callable[[bytes], bytes] = bytes  # makes the file of what was mutated, where that is a part of it


class Parser(NamedTuple):
    """A parser."""

    damages: Callable[[], list[Damage]]  # which files are damaged and how, in turns
    read: Callable[[Path, str], object]  # given the folder and the damaged file's name
    slow: int = 1  # by how many times fewer inputs are tried, because each takes a process or makes pages


def _one(
    name: str, content: Callable[[], bytes], mutations: tuple[Mutation, ...]
) -> Callable[[], list[Damage]]:
    return lambda: [Damage({name: content()}, name, mutations)]


def _robots() -> list[Damage]:
    sets = parser_files.robots()
    damages = [Damage(files, name, TEXT) for name, files in sets.items()]
    return [*damages, Damage(sets["robot.toml"], "robot.toml", TEXT)]


def _plan() -> list[Damage]:
    files = {"plan.toml": parser_files.plan().encode()}
    return [Damage(files, "plan.toml", TEXT), *[Damage(files, "plan.toml", TEXT, _by_hand)] * 3]


def _by_hand(text: bytes) -> bytes:
    """Without the checksum, as what was written by hand."""
    return b"\n".join(line for line in text.split(b"\n") if not line.startswith(b"checksum"))


def _recording() -> list[Damage]:
    """The file as it is; without compression; what explains it; and its values."""
    name, loose = "run.mcap", parser_files.rewritten()
    files, contents = {name: loose}, parser_files.explanation()
    robot = {name: contents.attachments["robot.toml"].data}
    output = {name: json.dumps(contents.metadata["exidyn"]).encode()}
    values = {name: np.array(parser_files.short_run().signals["position"].values).tobytes()}
    return [
        Damage({name: parser_files.recording_bytes()}, name, BINARY),
        Damage(files, name, BINARY),
        Damage(files, name, TEXT),
        Damage(robot, name, TEXT, lambda text: parser_files.rewritten(attachments={"robot.toml": text})),
        Damage(output, name, (tree, number, value), _explained),
        Damage(values, name, (double,), parser_files.with_positions),
    ]


def _explained(text: bytes) -> bytes:
    """A recording with this JSON as its metadata."""
    try:
        table = json.loads(text)
    except ValueError:
        table = {"format": "1", "name": text.decode()}
    entries = table.items() if isinstance(table, dict) else ()
    printable = {str(key): str(entry).encode(errors="replace").decode() for key, entry in entries}
    return parser_files.rewritten({"exidyn": printable})


def _trace() -> list[Damage]:
    files = parser_files.trace()
    header, data = "run_NextGenDrive#1.dat", "run_NextGenDrive#1.r64"
    return [Damage(files, header, TEXT), Damage(files, header, TEXT), Damage(files, data, BINARY)]


def _diagnosis() -> list[Damage]:
    files = parser_files.diagnosis_files()
    alone = {"diagnosis.json": files["diagnosis.json"]}
    return [
        Damage(alone, "diagnosis.json", JSON),
        Damage(files, "diagnosis.json", JSON),
        Damage(files, "traces.npz", BINARY),
    ]


def _fit_by_hand() -> list[Damage]:
    return [
        Damage({"fit.json": content()}, "fit.json", (*EDITED, *[scaled] * 5))
        for content in (parser_files.fit_bytes, parser_files.currents_fit_bytes)
    ]


def _diagnosis_by_hand() -> list[Damage]:
    files = parser_files.diagnosis_files()
    alone = {"diagnosis.json": files["diagnosis.json"]}
    return [Damage(one, "diagnosis.json", EDITED) for one in (alone, files)]


def _preset() -> list[Damage]:
    """As text, and by its values."""
    name, table = "preset.toml", json.dumps(parser_files.PRESET).encode()
    run = {"run.csv": parser_files.table()}
    return [
        Damage({**run, name: parser_files.toml_of(table)}, name, TEXT),
        *[Damage({**run, name: table}, name, EDITED, parser_files.toml_of)] * 3,
    ]


def _packed(name: str, plain: Callable[[], bytes]) -> Callable[[], list[Damage]]:
    """A compressed file: its bytes, and what is in it."""
    return lambda: [
        Damage({name: gzip.compress(plain())}, name, BINARY),
        Damage({name: plain()}, name, TEXT, gzip.compress),
    ]


def _npz() -> bytes:
    file = BytesIO()
    run = parser_files.short_run().signals["position"]
    np.savez_compressed(file, t=run.time, q=run.values, i=run.values)
    return file.getvalue()


def _controllers() -> list[Damage]:
    texts = [
        f'driver = "{name}"\n[settings]\n{settings}' for name, settings in parser_files.CONTROLLERS.items()
    ]
    return [Damage({"cell.toml": text.encode()}, "cell.toml", TEXT) for text in texts]


def _read_recording(folder: Path, name: str) -> None:
    """As `exidyn info` does, printed and as JSON; and as `exidyn info --repair` does."""
    for recording in import_source(folder / name):
        describe(recording)
        json_text({"recordings": [recording_table(recording)]})


def _recover(folder: Path, name: str) -> None:
    (folder / "whole.mcap").unlink(missing_ok=True)
    recover(folder / name, folder / "whole.mcap")


def _read_diagnosis(folder: Path, name: str) -> None:
    read_shown(folder / "diagnosis.json")


def _view_diagnosis(folder: Path, name: str) -> None:
    view_of([folder / "diagnosis.json"])


def _read_controller(folder: Path, name: str) -> None:
    driver, settings = read_controller(folder / name, None, ())
    make_driver(driver, settings, two_joints.arm())


MODEL = two_joints.model()
PARSERS: dict[str, Parser] = {
    "robot.toml": Parser(_robots, lambda folder, name: read_model(folder / name)),
    "trajectory.toml": Parser(_plan, lambda folder, name: read_plan(folder / name)),
    "URDF": Parser(
        _one("robot.urdf", parser_files.URDF.encode, TEXT), lambda folder, name: read_model(folder / name)
    ),
    "CSV": Parser(
        _one("run.csv", parser_files.table, TEXT), lambda folder, name: import_source(folder / name, MODEL)
    ),
    "recording": Parser(_recording, _read_recording),
    "recovery": Parser(lambda: _recording()[:3], _recover),
    "KUKA trace": Parser(_trace, lambda folder, name: import_source(folder, MODEL)),
    "fit.json": Parser(
        _one("fit.json", parser_files.fit_bytes, JSON), lambda folder, name: read_fit(folder / name)
    ),
    "diagnosis": Parser(_diagnosis, _read_diagnosis),
    "diagnosis view": Parser(_diagnosis, _view_diagnosis),
    "fit, exported": Parser(_fit_by_hand, lambda folder, name: fuzz_uses.export(folder / name)),
    "fit, reported": Parser(_fit_by_hand, lambda folder, name: fuzz_uses.report(folder / name)),
    "diagnosis, reported": Parser(
        _diagnosis_by_hand, lambda folder, name: fuzz_uses.report(folder / "diagnosis.json")
    ),
    "preset": Parser(
        _preset, lambda folder, name: import_source(folder / "run.csv", MODEL, preset=folder / name)
    ),
    "MATLAB": Parser(
        _one("run.mat", parser_files.matlab, BINARY),
        lambda folder, name: import_source(folder / name, MODEL),
        4,
    ),
    "HDF5": Parser(
        _one("run.h5", parser_files.hdf5, BINARY), lambda folder, name: import_source(folder / name, MODEL), 4
    ),
    "CSV, compressed": Parser(
        _packed("run.csv.gz", parser_files.table), lambda folder, name: import_source(folder / name, MODEL)
    ),
    "NumPy": Parser(_one("run.npz", _npz, BINARY), lambda folder, name: import_source(folder / name, MODEL)),
    "RTDE": Parser(
        _one("packages", parser_files.rtde_packages, PACKETS),
        lambda folder, name: fuzz_uses.hear(folder / name),
    ),
    "controller.toml": Parser(_controllers, _read_controller),
    "RSI configuration": Parser(
        _one("rsi.xml", lambda: config_text(standard_config("172.31.1.150")).encode(), TEXT),
        lambda folder, name: read_config(folder / name),
    ),
}
