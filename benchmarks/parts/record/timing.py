"""Every driver against its peer: cycles, what was missed, how late, what it takes; beside the floor."""

import tempfile
import time
from collections.abc import Callable, Collection, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from common import show

from exidyn.acquire.run.stopping.watch import WatchLimits
from exidyn.drivers import Driver, DriverError

from .controllers import ARMS, CONTROLLERS, NoBus, controller
from .floor import APART, Floor, floor, move_away, on_the_loops
from .run import COBOT, Ran, cpu_time, job, run
from .sessions import echo, fci, latencies, report, rtde

SESSIONS = {"kuka_rsi": echo, "ur_rtde": rtde, "franka": fci}
"""Floors of drivers whose controller has the clock."""
STAMPED = ("ur_rtde", "franka")
"""Those whose lateness is counted from the controller's time stamps. A peer's clock stands still where the
peer does, after which all is late by as much: the quickest is looked for anew in each block."""

HEADER = [
    "driver", "cycle ms", "cycles", "missed", "floor's", "late p50 us", "p99 us", "max us", "floor p50 us",
    "p99 us", "max us", "p99 / floor", "work p50 ms", "p99 ms", "driver p50 ms", "CPU loop %", "recorder %",
    "peer %", "kB/s", "ended by",
]  # fmt: skip
BLOCKS = 5
"""A run is cut into so many; a p99 of lateness is the median of theirs, so that one burst of a machine that
others use too does not decide."""
STARTING = 20
"""Cycles at the beginning whose work is not counted: what is done once is done there."""
PATIENT = WatchLimits(missed=1.0, silence=0.2, stall=0.5, stale=1.0)
"""For runs that are to be measured to their end, however late this machine is."""
HELD_BACK = 0.5
"""Of a Franka's commands, for the same purpose [s]; the arm follows that much later."""
MEANING = f"""\
  missed    cycles without an exchange, and those in which a joint was silent; the floor's are those that it
            slept through, and for controllers with a clock, what came later than the next
  late      from the deadline of a cycle until the loop runs; for the mock, that includes its own arithmetic
  kuka_rsi  from a telegram until the controller has the answer, as the controller measures it
  ur_rtde   from a package's time stamp until the loop runs, over the quickest of the same part of the run;
            the controller's own lateness and the network are in it. So are those of franka, whose states pass
            through a process of the driver's on the same processor, and wait while the loop is late
  floor     the same for a loop in C that does nothing, at the same time and cycle, on the loop's processor
            and one priority above. Where the controller has the clock, sessions with other such controllers,
            one before and one after, of six lines of Python
  p99       of lateness: the median of the p99 of {BLOCKS} parts of the run, likewise for the floor
  work      of the loop's thread in a cycle, driver and loop together, without waiting; p99 of the whole run
  peer      simulates drives and arm on another processor than the loop's where there is one, as the recorder
            is; a controller would be on none of this computer's"""


@dataclass(frozen=True)
class Measured:
    """One driver's run and what belongs to it."""

    ran: Ran  # The run
    lateness: tuple[float, float, float]  # Median, 99th percentile by blocks, and largest [us]
    bare: tuple[float, float, float]  # The same of the floor
    bare_missed: int  # Cycles that the floor missed
    cpu_peer: float  # CPU time that the peer took [s]
    krc: dict[str, Any]  # What the KUKA controller counted; empty for others

    @property
    def missed(self) -> int:
        """Cycles without an exchange, or with a joint that was silent."""
        counts = self.ran.outcome.counts
        return counts.skipped + counts.stale

    @property
    def ratio(self) -> float:
        """99th percentile of the lateness over that of the floor."""
        return self.lateness[1] / self.bare[1]

    @property
    def work(self) -> tuple[float, float, float]:
        """Median and 99th percentile of a cycle's work, and the median of the driver's share of it [ms]."""
        counts = self.ran.outcome.counts
        p50, p99 = 1e3 * np.percentile(counts.work[STARTING:], [50, 99])
        return float(p50), float(p99), float(1e3 * np.median(counts.driver_work[STARTING:]))


def measure(name: str, seconds: float, folder: Path) -> Measured:
    """Run one driver for some seconds; its recording is in the folder.

    Raises:
        NoBus: This machine has no such bus.
    """
    watch, settings = PATIENT, {}
    if name == "franka":
        watch, settings = replace(PATIENT, delay=HELD_BACK + 0.1), {"buffer": HELD_BACK}
    work = job(seconds, ARMS.get(name, COBOT), watch=watch)
    session = SESSIONS.get(name)
    sessions = [session(0.5 * seconds)] if session else []
    with controller(name, folder, **settings) as (driver, peer), on_the_loops():
        if peer:
            move_away(peer.process.pid)
        beside = nullcontext(Floor()) if session else floor(cycle_of(driver))
        during = _times(driver)
        used = cpu_time(peer.process.pid) if peer else 0.0
        with beside as bare:
            ran = run(driver, work, folder / f"{name}.mcap", started=move_away)
        used = cpu_time(peer.process.pid) - used if peer else 0.0
        krc = report(peer) if name == "kuka_rsi" and peer else {}
    late = latencies(krc) if krc else ran.outcome.counts.lateness
    sessions += [session(0.5 * seconds)] if session else [slept(bare, during, cycle_of(driver))]
    floors = np.concatenate([one for one, _ in sessions])
    missed = sum(count for _, count in sessions)
    stamped = name in STAMPED
    return Measured(ran, _of(late, stamped), _of(floors, stamped), missed, used, krc)


def slept(bare: Floor, during: Sequence[float], cycle: float) -> tuple[np.ndarray, int]:
    """Lateness of a floor's ticks between two times, shape (t,) [s], and how many cycles it slept through."""
    lateness = bare.lateness(*during)
    return lateness, int(np.sum(lateness // cycle))


def _times(driver: Driver) -> list[float]:
    """Filled with when the driver was armed and when it was closed, by the monotonic clock [s]."""
    times: list[float] = []

    def noted(does: Callable[[], None], place: int) -> Callable[[], None]:
        def done() -> None:
            if len(times) == place:
                times.append(time.monotonic())
            does()

        return done

    driver.arm_drives = noted(driver.arm_drives, 0)  # type: ignore[method-assign]
    driver.close = noted(driver.close, 1)  # type: ignore[method-assign]
    return times


def cycle_of(driver: Driver) -> float:
    """Time between exchanges [s], before the driver is open."""
    return float(getattr(driver.settings, "cycle", 0.001))


def _of(lateness: Any, stamped: bool) -> tuple[float, float, float]:
    """Median, 99th percentile by blocks, and largest [us]; if stamped, over the quickest of each block."""
    blocks = np.array_split(1e6 * np.asarray(lateness), BLOCKS)
    blocks = [block - block.min() for block in blocks] if stamped else blocks
    p99 = np.median([np.percentile(block, 99) for block in blocks])
    every = np.concatenate(blocks)
    return float(np.median(every)), float(p99), float(every.max())


def measure_all(seconds: float, folder: Path, drivers: Collection[str]) -> dict[str, Measured]:
    """Drivers, one after another; those without a bus, or whose peer is too late thrice, are named."""
    found: dict[str, Measured] = {}
    for name in drivers or CONTROLLERS:
        for _ in range(3):
            try:
                found[name] = measure(name, seconds, folder)
                break
            except (NoBus, DriverError) as error:  # a busy machine can be too late to answer
                print(f"{name}: {error}")
                if isinstance(error, NoBus):
                    break
    return found


def table(found: dict[str, Measured], seconds: float) -> dict[str, Any]:
    """Print the table; the figures of it."""
    show(f"{seconds:g} s of motion through each driver", HEADER, [_row(*one) for one in found.items()])
    print(MEANING)
    if not APART:
        print("  Loop, floor, peer and recorder share their processors: the figures are the peer's too.")
    refused = {text for one in found.values() for text in one.ran.refused}
    for text in sorted(refused):
        print(f"  refused: {text}")
    return {
        "missed_cycles": {name: one.missed for name, one in found.items()},
        "missed_cycles_floor": {name: one.bare_missed for name, one in found.items()},
        "cycles": {name: one.ran.outcome.counts.cycles for name, one in found.items()},
        "lateness_p99_over_floor": {name: one.ratio for name, one in found.items()},
        "cycle_ms_p50": {name: one.work[0] for name, one in found.items()},
        "cycle_ms_p99": {name: one.work[1] for name, one in found.items()},
        "driver_ms_p50": {name: one.work[2] for name, one in found.items()},
        "rsi_timeout_stops": sum("RSITimeout" in one.krc["stopped"] for one in found.values() if one.krc),
        "ended_early": [name for name, one in found.items() if one.ran.outcome.stop],
    }


def _row(name: str, one: Measured) -> list[Any]:
    ran, counts = one.ran, one.ran.outcome.counts
    cpu = [100 * used / ran.seconds for used in (ran.cpu, ran.cpu_recorder, one.cpu_peer)]
    rate = ran.path.stat().st_size / ran.seconds * 1e-3 if ran.path.exists() else np.nan
    stop = ran.outcome.stop
    loop = [name, 1e3 * ran.outcome.info.cycle, counts.cycles, one.missed, one.bare_missed, *one.lateness]
    return [*loop, *one.bare, one.ratio, *one.work, *cpu, rate, stop.text if stop else "its end"]


def main(quick: bool, drivers: Collection[str] = ()) -> dict[str, Any]:
    seconds = 2.5 if quick else 60.0
    with tempfile.TemporaryDirectory() as folder:
        return table(measure_all(seconds, Path(folder), drivers), seconds)
