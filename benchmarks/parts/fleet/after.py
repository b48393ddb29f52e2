"""What comes after identification: reading what is kept, asking what changed, the page."""

import time
import tracemalloc
from collections.abc import Callable
from typing import Any

from exidyn.acquire.fleet.analysis import learned_of, write_tables
from exidyn.acquire.fleet.store import Store
from exidyn.identification.fleet.report import KindReport
from exidyn.identification.pages.fleet_document import fleet_page

KILO = 1e3


def after_figures(store: Store, rate: float = 1.0) -> dict[str, float]:
    """CPU time [ms] and memory [kB] a run, of the page an arm; memory is what is held."""
    runs = len(store.index())
    by_file = _milliseconds(store.index) / len(list(store.runs.glob("*/*/*.parquet")))
    read = _milliseconds(lambda: [store.arms(key) for key in store.kinds()])
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    kept = [learned_of(store, key) for key in store.kinds()]
    held = (tracemalloc.get_traced_memory()[0] - before) / KILO
    tracemalloc.stop()
    learned = _milliseconds(lambda: [learned_of(store, key) for key in store.kinds()]) - read
    found: list[KindReport] = []
    pairs = [(key, one) for key, one in zip(store.kinds(), kept, strict=True) if one is not None]
    asked = _milliseconds(lambda: found.extend(KindReport.of(key, one, rate) for key, one in pairs))
    tables = _milliseconds(lambda: write_tables(store, found))
    page = _milliseconds(lambda: fleet_page(found, [], {}, rate))
    return {
        "index_ms_a_file": by_file,
        "read_ms_a_run": read / runs,
        "learned_ms_a_run": learned / runs,
        "changes_ms_a_run": asked / runs,
        "tables_ms_a_run": tables / runs,
        "page_ms_an_arm": page / sum(len(one.drifts) for one in found),
        "held_kilobytes_a_run": held / runs,
    }


def _milliseconds(work: Callable[[], Any]) -> float:
    begin = time.process_time()
    work()
    return 1e3 * (time.process_time() - begin)
