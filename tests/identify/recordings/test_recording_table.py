"""A recording as a table, read again as it was."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.recordings.tables.written import TABLES, columns_of, left_out

from ...parts.runs.full_run import recording as full_run
from ...parts.runs.runs import TIME, model, motion, noise


def two_rates() -> Recording:
    """Slow temperatures, currents between the positions, and a second encoder on one joint."""
    link = motion()
    link[:, 1] = np.nan
    signals = {
        "position": Signal(TIME, motion()),
        "current": Signal(TIME + 0.001, noise()),
        "temperature": Signal(TIME[::10], 40 + noise()[::10]),
        "link_position": Signal(TIME, link),
    }
    return Recording("run", model(), signals)


@pytest.mark.parametrize("form", TABLES)
@pytest.mark.parametrize("run", [two_rates(), full_run()], ids=["two rates", "every signal"])
def test_a_table_is_read_again_as_it_was_written(tmp_path, form, run, in_process):
    if form == "parquet":
        pytest.importorskip("pyarrow")
    (tmp_path / f"run.{form}").write_bytes(TABLES[form](run))
    [found] = import_source(tmp_path / f"run.{form}", run.model)
    assert set(found.signals) == set(run.signals)
    for name, signal in run.signals.items():
        assert np.array_equal(found.signals[name].values, signal.values, equal_nan=True)
        start = min(one.time[0] for one in run.signals.values())
        np.testing.assert_allclose(found.signals[name].time, signal.time - start, atol=1.1e-9)


def test_parquet_is_read_by_pandas(tmp_path):
    pandas, _ = pytest.importorskip("pandas"), pytest.importorskip("pyarrow")
    (tmp_path / "run.parquet").write_bytes(TABLES["parquet"](two_rates()))
    frame = pandas.read_parquet(tmp_path / "run.parquet")
    assert list(frame) == list(columns_of(two_rates()))
    assert "ql2" not in frame
    assert np.array_equal(frame["i2"].dropna(), noise()[:, 1])
    assert frame["temp1"].isna().sum() == len(frame) - 20


def test_what_a_table_cannot_hold_is_listed():
    run = two_rates()
    assert left_out(run) == ["the robot and its nominal values: import needs --robot"]
    loaded = replace(run, payload=KnownPayload("brick"), trajectory="x", host_time=np.arange(200))
    assert [line for line in left_out(loaded) if "brick" in line]
    assert len(left_out(loaded)) == 4
