"""`exidyn fleet` on real files: stopped and resumed, on processes and on Dask, read by DuckDB."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

import duckdb
import pytest

from exidyn.acquire.arguments.exit_codes import DONE, LOST
from exidyn.acquire.command_line import main
from exidyn.acquire.fleet.source import Source, date_of
from exidyn.acquire.fleet.store import Store
from exidyn.acquire.fleet.work import identify_new, left_out
from exidyn.identification.errors import NotAFile, RecordingError

from ...parts.small import fleet_runs, two_joints

ARMS, WEEKS = 2, 5
ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """A folder of runs, one of which is damaged."""
    folder = tmp_path_factory.mktemp("check runs")
    fleet_runs.write_season(folder, ARMS, WEEKS)
    (folder / "arm 1" / "2026-01-03 broken.mcap").write_bytes(b"no recording")
    return folder


@pytest.fixture(scope="module")
def whole(recordings, tmp_path_factory):
    """What comes of them in one go."""
    store = Store(tmp_path_factory.mktemp("whole"))
    with ThreadPoolExecutor(1) as executor:
        assert identify_new(Source(str(recordings)), store, executor) == ARMS * WEEKS + 1
    return store


def contents(store):
    """All that is kept of every run, but for the order in which it was kept."""
    return duckdb.sql(
        "SELECT * REPLACE (CAST(date AS VARCHAR) AS date) FROM "
        f"read_parquet('{store.runs}/*/*/*.parquet', hive_partitioning = true) ORDER BY key"
    ).fetchall()


def test_duckdb_reads_runs_by_arm_and_month(whole):
    found = duckdb.sql(
        f"SELECT arm, count(*) FROM read_parquet('{whole.runs}/*/*/*.parquet', hive_partitioning = true) "
        "WHERE error = '' GROUP BY arm ORDER BY arm"
    ).fetchall()
    assert [count for _, count in found] == [WEEKS] * ARMS


def test_a_damaged_recording_is_left_out_with_the_reason(whole):
    [(file, why)] = left_out(whole)
    assert file == "arm 1/2026-01-03 broken.mcap"
    assert "not an MCAP file" in why


def test_nothing_is_done_twice(recordings, whole, tmp_path):
    before = contents(whole)
    copy = tmp_path / "more"
    shutil.copytree(recordings, copy, copy_function=shutil.copy)  # other files, the same contents
    with ThreadPoolExecutor(1) as executor:
        assert identify_new(Source(str(recordings)), whole, executor) == 0
        assert identify_new(Source(f"file://{copy}"), whole, executor) == ARMS * WEEKS + 1
    assert contents(whole) == before


def test_killed_and_resumed_it_is_the_same_table(recordings, whole, tmp_path):
    command = [sys.executable, "-m", "exidyn.acquire.command_line", "fleet", str(recordings)]
    command += ["-o", str(tmp_path / "out"), "--workers", "1"]
    killed = subprocess.Popen(command, start_new_session=True, cwd=ROOT, stderr=subprocess.DEVNULL)
    store = Store(tmp_path / "out")
    until(lambda: len(list(store.runs.glob("*/*/*.parquet"))) >= 2)
    os.killpg(killed.pid, signal.SIGKILL)
    killed.wait()
    assert len(store.index()) < ARMS * WEEKS
    assert subprocess.run(command, cwd=ROOT, capture_output=True, check=False).returncode == LOST
    assert contents(store) == contents(whole)
    assert (store.folder / "fleet.html").read_text().count("<svg") >= ARMS


@pytest.mark.slow
def test_dask_goes_on_when_a_worker_is_killed(recordings, whole, tmp_path):
    distributed = pytest.importorskip("distributed")
    store = Store(tmp_path / "out")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        victim = next(iter(client.run(os.getpid).values()))
        killed = []

        def note(done, of):
            if done == 2 and not killed:
                os.kill(victim, signal.SIGKILL)
                killed.append(done)

        identify_new(Source(str(recordings)), store, client.get_executor(), note)
    assert killed
    assert contents(store) == contents(whole)


def test_the_command_prints_writes_and_compares(recordings, tmp_path, capsys):
    out = tmp_path / "out"
    assert (
        main(["fleet", str(recordings), "-o", str(out), "--workers", "1", "--json", str(tmp_path / "a.json")])
        == LOST
    )
    printed = capsys.readouterr().out
    assert "two joints: 2 arms, 10 runs" in printed
    assert "cannot be used: arm 1/2026-01-03 broken.mcap: " in printed
    assert "rate of false alarms unknown" in printed  # of five runs an arm
    assert main(["fleet", "compare", "arm 1@2026-01-01", "arm 1@2026-01-15", "-o", str(out)]) == 0
    assert "do not differ" in capsys.readouterr().out
    assert main(["fleet", "compare", "arm 1", "arm 9", "-o", str(out)]) != 0
    assert "no runs of arm 9" in capsys.readouterr().err
    values = duckdb.sql(f"SELECT count(*) FROM read_parquet('{out}/values/*/*/*.parquet')").fetchall()
    assert values[0][0] >= ARMS * WEEKS * 6


def test_the_page_links_to_reports_that_are_made_once(recordings, tmp_path, capsys):
    command = ["fleet", str(recordings), "-o", str(tmp_path / "out"), "--workers", "1", "--reports"]
    assert main(command) == LOST
    page = (tmp_path / "out" / "fleet.html").read_text()
    links = re.findall(r'href="(reports/[^"]*)"', page)
    made = [tmp_path / "out" / unquote(link) for link in links]
    assert len(made) == ARMS
    assert all("two joints" in path.read_text() for path in made)
    written = [path.stat().st_mtime_ns for path in made]
    assert main(command) == LOST
    assert [path.stat().st_mtime_ns for path in made] == written


def test_a_file_cut_at_two_thirds_is_used_and_marked(recordings, tmp_path, capsys):
    source = tmp_path / "cut"
    shutil.copytree(recordings / "arm 2", source / "arm 2")
    path = source / "arm 2" / "week-00.mcap"
    path.write_bytes(path.read_bytes()[: 2 * path.stat().st_size // 3])
    out = tmp_path / "out"
    assert main(["fleet", str(source), "-o", str(out), "--workers", "1"]) == DONE
    printed = capsys.readouterr().out
    assert "incomplete, used as far as it goes: arm 2/week-00.mcap: file ends abruptly" in printed
    assert "Incomplete recordings" in (out / "fleet.html").read_text()


def test_a_date_is_the_clocks_or_the_names():
    run = fleet_runs.check_run({}, two_joints.GAIN, [30.0, 30.0], 20454.5)
    assert date_of(run, "a/b.mcap").isoformat() == "2026-01-01T12:00:00+00:00"
    bare = replace(run, host_time=None)
    assert date_of(bare, "a/2026-05-03T0830.mcap").isoformat() == "2026-05-03T08:30:00+00:00"
    with pytest.raises(RecordingError, match="date"):
        date_of(bare, "a/b.mcap")


def test_an_empty_folder_is_refused(tmp_path):
    with pytest.raises(NotAFile, match="no recordings"):
        Source(str(tmp_path)).files()


def until(true, seconds=300.0):
    """Wait."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)
