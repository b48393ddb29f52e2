"""Who writes while the loop runs: a thread of its own process, or a process of its own?

A 500 Hz loop with real-time scheduling hands over six joints to no one, to a thread and to a process, which
write the same file in the same way, on a quiet machine and beside two busy processes. Each is run in a
process of its own. Compared is how late the loop is, and how long it takes to hand over.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

from common import options, save, show
from parts.record.handing_over import WHO, measured


def main() -> None:
    chosen = options(__doc__.splitlines()[0])
    seconds = 5.0 if chosen.quick else 30.0
    found = {(load, who): measured(who, load, seconds) for load in (0, 2) for who in WHO}
    rows = [
        ["busy" if load else "quiet", who, *f["lateness_us"], f["skipped"], *f["put_us"], 100 * f["cpu"]]
        for (load, who), f in found.items()
    ]
    header = [
        "machine",
        "written by",
        "late p50 us",
        "p99 us",
        "max us",
        "skipped",
        "put p50 us",
        "p99 us",
        "CPU %",
    ]
    show(f"A 500 Hz loop of {seconds:g} s handing over six joints", header, rows)
    if not all(figures["real_time"] for figures in found.values()):
        print("real-time scheduling was refused: all loops were scheduled as usual")
    ratio = {
        load: found[load, "thread"]["lateness_us"][1] / found[load, "process"]["lateness_us"][1]
        for load in (0, 2)
    }
    print(f"p99 of lateness, thread over process: {ratio[0]:.2f} quiet, {ratio[2]:.2f} busy")
    save(chosen.json, {"thread_over_process_p99": ratio[2], "thread_over_process_p99_quiet": ratio[0]})


if __name__ == "__main__":
    main()
