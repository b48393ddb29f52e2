"""The same arm through several drivers: what is identified of it beside what it is, and beside each other."""

import tempfile
from collections.abc import Collection
from contextlib import nullcontext
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from common import show

from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.mcap.mcap_file import read_recording

from ..controllers import ARMS, SEVEN, NoBus, controller
from ..motion import COBOT, job
from ..run import run
from .lockstep import lockstep
from .table import patient

DRIVERS = ("mock", "kuka_rsi", "ur_rtde", "canopen_402", "can_mit", "dynamixel", "feetech", SEVEN, "franka")
QUICK_DRIVERS = ("mock", "canopen_402")
ATTEMPTS = 3
"""At a whole run: a machine that is busy otherwise can be too late for one."""
OTHER = {name: {"clock": "stepped"} for name in ("mock", SEVEN)}
"""Settings of drivers that fit here better: there is no wait for what is only simulated."""
OWN_TIME = ("mock", "kuka_rsi", "ur_rtde", SEVEN, "franka")
"""Drivers whose controller has a clock of its own; for others, this machine's lateness is left out."""
INSIDE = 1.96
"""Deviation of 95 % of normal numbers [standard deviations]."""


class Identified(NamedTuple):
    """Results of a recording.

    Attributes:
        names: Of base parameters.
        values: Shape (p,), as identified.
        std: Shape (p,).
        truth: Shape (p,), of the arm that was simulated.
        over_noise: Median over joints of the residual over the noise floor [-].
    """

    names: tuple[str, ...]
    values: np.ndarray
    std: np.ndarray
    truth: np.ndarray
    over_noise: float

    @property
    def error(self) -> np.ndarray:
        """Away from the truth, shape (p,) [standard deviations]."""
        return (self.values - self.truth) / self.std


def identified(path: Path) -> Identified:
    """Base parameters out of a recording, with nominal drive gains."""
    recording = read_recording(path)
    fit: Fit = identify([recording], drop=False)
    model = recording.model
    true = dict(zip(model.names, model.nominal_values, strict=True))
    truth = fit.base.regrouping @ [true[parameter.name] for parameter in fit.base.parameters]
    noise = float(np.median(fit.agreement[0].over_noise))
    return Identified(tuple(fit.base.names), fit.estimate.values, fit.estimate.std, truth, noise)


def recordings(names: tuple[str, ...], seconds: float, folder: Path) -> dict[str, Path]:
    """The motion recorded through each driver, one after another."""
    found = {}
    for name in names:
        for attempt in range(ATTEMPTS):
            try:
                arguments = () if name in OWN_TIME else ("--lockstep",)
                watch, settings = patient(name)
                settings |= OTHER.get(name, {})
                work = job(seconds, ARMS.get(name, COBOT), watch=watch)
                with (
                    nullcontext() if name in OWN_TIME else lockstep(),
                    controller(name, folder, *arguments, **settings) as (driver, _),
                ):
                    ran = run(driver, work, folder / f"{name}-{attempt}.mcap")
            except NoBus as error:
                print(f"{name}: {error}")
                break
            if ran.outcome.stop is None:
                found[name] = ran.path
                break
            print(f"{name}: stopped: {ran.outcome.stop.text}")
    return found


def agreement(paths: dict[str, Path]) -> dict[str, Any]:
    """Print how well recordings agree; the figures. The mock's of each arm is one of them."""
    found = {name: identified(path) for name, path in paths.items()}
    mocks = {name: found[SEVEN if name in ARMS else "mock"] for name in found}
    rows = [_row(name, one, mocks[name]) for name, one in found.items()]
    header = [
        "driver", "parameters", "truth in 95 % %", "most std off", "at", "mock's in 95 % %", "most std off",
        "std over mock's", "residual over noise",
    ]  # fmt: skip
    show("Base parameters identified from recordings of the same arm and motion", header, rows)
    return {
        "agreement": {name: _inside(one.error) for name, one in found.items()},
        "agreement_with_mock": {name: _inside(_between(one, mocks[name])) for name, one in found.items()},
        "most_std_off": {name: float(np.max(np.abs(one.error))) for name, one in found.items()},
    }


def _row(name: str, one: Identified, mock: Identified) -> list[Any]:
    worst = int(np.argmax(np.abs(one.error)))
    apart, std = _between(one, mock), float(np.median(one.std / mock.std))
    own = [len(one.names), 100 * _inside(one.error), abs(one.error[worst]), one.names[worst]]
    other = [np.nan, np.nan] if one is mock else [100 * _inside(apart), np.max(np.abs(apart))]
    return [name, *own, *other, std, one.over_noise]


def _between(one: Identified, other: Identified) -> np.ndarray:
    """Apart from each other, shape (p,) [standard deviations of the difference]."""
    return (one.values - other.values) / np.hypot(one.std, other.std)


def _inside(error: np.ndarray) -> float:
    return float(np.mean(np.abs(error) < INSIDE))


def main(quick: bool, drivers: Collection[str] = ()) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        names, seconds = (QUICK_DRIVERS, 8.0) if quick else (DRIVERS, 20.0)
        if drivers:
            beside = {SEVEN if name in ARMS else "mock" for name in drivers}
            names = tuple(name for name in DRIVERS if name in beside | set(drivers))
        return agreement(recordings(names, seconds, Path(folder)))
