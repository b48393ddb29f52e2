"""exidyn fleet: find which of many arms changed, in what, and since when."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from urllib.parse import quote

from exidyn.identification.fleet.drift import LEAST
from exidyn.identification.fleet.report import (
    KindReport,
    bound_words,
    change_words,
    difference_words,
    odd_words,
)
from exidyn.identification.notebook import counted

from ..arguments.command import Command, Option, WrongUse, not_negative, print_warning
from ..arguments.exit_codes import DONE, LOST
from ..arguments.options import ALARMS, FLEET, JSON, make_folder, output_option
from ..fleet.analysis import change_rows, differences, odd_rows, reports, write_tables
from ..fleet.source import Source
from ..fleet.store import Store
from ..fleet.work import (
    LOCAL,
    executor_of,
    identify_new,
    last_runs,
    left_out,
    not_whole,
    report_path,
    write_reports,
)
from ..screen import beneath
from ..terminal.json_output import hand_over, json_text, print_written, write_whole

PAGE = "fleet.html"
FORMAT = "1"
"""Format number of the JSON."""


@Command(
    "Find which of many arms changed, in what, and since when; each new recording is identified\n"
    "once. 'compare ARM ARM' compares two arms, or one arm at two times: ARM@2026-05-03.",
    (
        "exidyn fleet check-runs",
        "exidyn fleet s3://plant/check-runs --cluster tcp://scheduler:8786 -o /shared/fleet",
        "exidyn fleet compare welding-07 welding-12",
        "exidyn fleet compare welding-07@2026-03 welding-07@2026-05",
    ),
    (
        Option(
            "sources FOLDER...",
            "recordings, ARM/RUN.mcap, or an address that fsspec reads; or: compare ARM ARM",
        ),
        ALARMS,
        Option("--reports", "write a page on each arm's last run, and link to it"),
        Option("--workers N", "processes on this machine; default: number of cores", not_negative),
        Option(
            "--cluster ADDRESS",
            f"address of a Dask scheduler, tcp://HOST:PORT; or {LOCAL} to start one on this machine",
        ),
        output_option("FOLDER", FLEET),
        JSON,
    ),
    usage="exidyn fleet FOLDER [options]\n       exidyn fleet compare ARM ARM [-o FOLDER] [--json FILE]",
)
def fleet_command(args: Namespace) -> int:
    """Identify new recordings, find changes, print and write them; or compare two arms."""
    if args.sources[0] == "compare" and len(args.sources) == 3:
        _compare(args)
        return DONE
    if len(args.sources) != 1:
        raise WrongUse("expected one FOLDER, or: compare ARM ARM")
    make_folder(args.output)
    source, store = Source(args.sources[0]), Store(args.output.resolve())
    files = {file.path for file in source.files()}
    with executor_of(args.cluster, args.workers) as executor:
        new = identify_new(source, store, executor, _progress)
        tell = partial(_progress, noun="report")
        for arm, why in write_reports(source, store, executor, tell) if args.reports else ():
            print_warning(f"{arm}: no report: {why}")
        kind_reports = reports(store, args.alarms_per_arm_year, executor)
    write_tables(store, kind_reports)
    unusable = [row for row in left_out(store) if row[0] in files]
    marked = [row for row in not_whole(store) if row[0] in files]
    table = {
        "exidyn_fleet": FORMAT,
        "new": new,
        "changes": [row for report in kind_reports for row in change_rows(report)],
        "odd_runs": [row for report in kind_reports for row in odd_rows(report)],
        "false_alarms_bounded": all(report.scatter.holds for report in kind_reports),
        "left_out": unusable,
        "not_whole": marked,
    }
    text = _text(kind_reports, new, args.alarms_per_arm_year)
    hand_over("\n".join([*text, *_files_text(unusable, marked)]), json_text(table), args.json)
    _write_page(source, store, kind_reports, args.alarms_per_arm_year, unusable, marked)
    return LOST if unusable else DONE


def _progress(done: int, total: int, noun: str = "new run") -> None:
    if sys.stderr.isatty() or done == total:
        end = "\n" if done == total else ""
        print(f"\r{done} of {counted(total, noun)}", end=end, file=beneath(sys.stderr), flush=True)


def _files_text(unusable: Sequence[tuple[str, str]], marked: Sequence[tuple[str, str]]) -> list[str]:
    """Lines on recordings that cannot be used, and on incomplete ones."""
    lines = []
    for words, files in (("cannot be used", unusable), ("incomplete, used as far as it goes", marked)):
        lines += [f"{words}: {path}: {why.removeprefix(path).lstrip(': ')}" for path, why in files]
    return lines


def _text(kind_reports: Sequence[KindReport], new: int, rate: float) -> list[str]:
    lines = []
    for report in kind_reports:
        arms, name = report.drifts, report.learned.frame.kind.model.robot.name
        runs = sum(len(arm_runs.runs) for arm_runs in report.learned.arms.values())
        lines.append(f"{name}: {counted(len(arms), 'arm')}, {counted(runs, 'run')}")
        changed = {arm: drift for arm, drift in arms.items() if drift.changes}
        for arm, drift in changed.items():
            lines += [f"  {arm}: {change_words(report.learned, change)}" for change in drift.changes]
        odd_runs = [(arm, run) for arm, drift in arms.items() for run in drift.odd]
        lines += [f"  {arm}: {odd_words(report.learned, run)}" for arm, run in odd_runs]
        few = sum(len(arm_runs.runs) < LEAST for arm_runs in report.learned.arms.values())
        unchanged = len(arms) - len(changed) - few
        if unchanged or not (few or changed):
            lines.append(f"  nothing changed on {counted(unchanged, 'other arm' if changed else 'arm')}")
        if few:
            lines.append(
                f"  too few runs to find changes on {counted(few, 'arm')}: at least {LEAST} are needed"
            )
    return [*lines, bound_words(kind_reports, rate), f"new: {counted(new, 'run')}"]


def _write_page(
    source: Source,
    store: Store,
    kind_reports: Sequence[KindReport],
    rate: float,
    unusable: Sequence[tuple[str, str]],
    marked: Sequence[tuple[str, str]],
) -> None:
    from exidyn.identification.pages.fleet_document import fleet_page

    links: dict[str, dict[str, str]] = {}
    for arm, row in last_runs(store).items():
        report = report_path(store, row)
        link = quote(report.relative_to(store.folder).as_posix())
        links[arm] = {"report": link} if report.exists() else {}
        links[arm]["last recording"] = (
            f"{source.address}/{row.file}"
            if source.remote
            else (Path(source.address) / row.file).resolve().as_uri()
        )
    path = store.folder / PAGE
    write_whole(path, fleet_page(kind_reports, unusable, links, rate, marked))
    print_written(path)


def _compare(args: Namespace) -> None:
    first, second = args.sources[1:]
    learned, differing = differences(Store(args.output.resolve()), first, second)
    joints = learned.frame.kind.model.robot.joints
    words = (f"  {difference_words(difference, joints)}" for difference in differing)
    lines = [f"{second} over {first}:", *words]
    if not differing:
        lines = [f"{first} and {second} do not differ by more than one arm does from run to run"]
    table = {"exidyn_fleet": FORMAT, "differences": [difference._asdict() for difference in differing]}
    hand_over("\n".join(lines), json_text(table), args.json)
