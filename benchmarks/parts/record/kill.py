"""Kill the recorder at random moments of a run, with and without the loop that feeds it: what is lost.

A program hands over six joints at 500 Hz, under the load of two busy processes. Lost is the time from the
last cycle that can be read to the last one that had been handed over when the signal came. Where the loop is
killed and the recorder is not, nothing may be lost.
"""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from common import show
from recorder_kills import kill

from .busy import busy

BOUND = 150.0
"""What may be lost [ms]."""
WHO = {"both": ("recorder", "loop"), "recorder": ("recorder",), "loop": ("loop",)}


def kills(count: int, victims: tuple[str, ...], seed: int = 0, longest: float = 3.0) -> dict[str, Any]:
    """Figures of so many runs, each ended by SIGKILL at a random moment of its first seconds."""
    moments = np.random.default_rng(seed).uniform(0.1, longest, count)
    lost, unreadable = [], 0
    for moment in moments:
        with tempfile.TemporaryDirectory() as folder:
            try:
                lost.append(kill(Path(folder), victims, float(moment)).lost_ms)
            except (ValueError, OSError) as error:  # a file that is no recording, or none
                print(f"unreadable after {moment:.3f} s: {error}")
                unreadable += 1
    return {"lost_ms": lost, "unreadable": unreadable}


def main(quick: bool) -> dict[str, Any]:
    counts = {"both": 1} if quick else {"both": 20, "recorder": 20, "loop": 10}
    with busy(2):
        found = {name: kills(count, WHO[name]) for name, count in counts.items()}
    rows = [
        [name, counts[name], figures["unreadable"], *np.percentile(figures["lost_ms"], [50, 100])]
        for name, figures in found.items()
    ]
    show(
        "SIGKILL at random moments", ["killed", "runs", "unreadable", "median lost ms", "most lost ms"], rows
    )
    return {
        "lost_ms": max(max(found[name]["lost_ms"]) for name in ("both", "recorder") if name in found),
        "lost_ms_recorder_alive": max(found["loop"]["lost_ms"]) if "loop" in found else None,
        "kills": sum(counts.values()),
        "unreadable": sum(figures["unreadable"] for figures in found.values()),
    }
