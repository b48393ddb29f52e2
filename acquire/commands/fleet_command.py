"""exidyn fleet: recordings of many arms in; what changed on which, and since when, out."""

import sys
from argparse import Namespace
from collections.abc import Sequence
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

from ..arguments.command import Command, Option, WrongUse, print_warning, whole
from ..arguments.exit_codes import DONE, LOST
from ..arguments.options import ALARMS, FLEET, JSON, make_folder, output_option, require_json
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
"""Of the JSON."""


@Command(
    "Which arm of many changed, in what, and since when; each new recording is identified once.\n"
    "'compare ARM ARM' states where two arms differ, or one at two times: ARM@2026-05-03.",
    (
        "exidyn fleet check-runs",
        "exidyn fleet s3://plant/check-runs --cluster tcp://scheduler:8786 -o /shared/fleet",
        "exidyn fleet compare welding-07 welding-12",
        "exidyn fleet compare welding-07@2026-03 welding-07@2026-05",
    ),
    (
        Option(
            "what FOLDER...", "recordings, ARM/RUN.mcap, or an address that fsspec reads; or: compare ARM ARM"
        ),
        ALARMS,
        Option("--reports", "make a page of each arm's last run, and link to it"),
        Option("--workers N", "processes on this machine; default: as many as cores", whole),
        Option("--cluster ADDRESS", f"of a Dask scheduler, tcp://HOST:PORT; or {LOCAL} to start one here"),
        output_option("FOLDER", FLEET),
        JSON,
    ),
    usage="exidyn fleet FOLDER [options]\n       exidyn fleet compare ARM ARM [-o FOLDER] [--json FILE]",
)
def fleet_command(given: Namespace) -> int:
    """Identify what is new, ask what changed, print, write; or compare two arms."""
    require_json(given.json)
    if given.what[0] == "compare" and len(given.what) == 3:
        _compare(given)
        return DONE
    if len(given.what) != 1:
        raise WrongUse("one FOLDER is expected, or: compare ARM ARM")
    make_folder(given.output)
    source, store = Source(given.what[0]), Store(given.output.resolve())
    files = {one.path for one in source.files()}
    with executor_of(given.cluster, given.workers) as executor:
        new = identify_new(source, store, executor, _progress)
        for arm, why in write_reports(source, store, executor, _reported) if given.reports else ():
            print_warning(f"{arm}: no report: {why}")
        found = reports(store, given.alarms_per_arm_year, executor)
    write_tables(store, found)
    unusable = [row for row in left_out(store) if row[0] in files]
    marked = [row for row in not_whole(store) if row[0] in files]
    table = {
        "exidyn_fleet": FORMAT,
        "new": new,
        "changes": [row for one in found for row in change_rows(one)],
        "odd_runs": [row for one in found for row in odd_rows(one)],
        "false_alarms_bounded": all(one.scatter.holds for one in found),
        "left_out": unusable,
        "not_whole": marked,
    }
    text = _text(found, new, given.alarms_per_arm_year)
    hand_over("\n".join([*text, *_files_text(unusable, marked)]), json_text(table), given.json)
    _write_page(source, store, found, given.alarms_per_arm_year, unusable, marked)
    return LOST if unusable else DONE


def _progress(done: int, of: int, what: str = "new run") -> None:
    if sys.stderr.isatty() or done == of:
        end = "\n" if done == of else ""
        print(f"\r{done} of {counted(of, what)}", end=end, file=beneath(sys.stderr), flush=True)


def _reported(done: int, of: int) -> None:
    _progress(done, of, "report")


def _files_text(unusable: Sequence[tuple[str, str]], marked: Sequence[tuple[str, str]]) -> list[str]:
    """Files that are of no use, and those that are not whole."""
    lines = []
    for words, files in (("cannot be used", unusable), ("not whole, used as far as it goes", marked)):
        lines += [f"{words}: {path}: {why.removeprefix(path).lstrip(': ')}" for path, why in files]
    return lines


def _text(found: Sequence[KindReport], new: int, rate: float) -> list[str]:
    lines = []
    for report in found:
        arms, name = report.drifts, report.learned.frame.kind.model.robot.name
        runs = sum(len(own.runs) for own in report.learned.arms.values())
        lines.append(f"{name}: {counted(len(arms), 'arm')}, {counted(runs, 'run')}")
        changed = {arm: own for arm, own in arms.items() if own.found}
        for arm, own in changed.items():
            lines += [f"  {arm}: {change_words(report.learned, one)}" for one in own.found]
        odd = [(arm, one) for arm, own in arms.items() for one in own.odd]
        lines += [f"  {arm}: {odd_words(report.learned, one)}" for arm, one in odd]
        few = sum(len(own.runs) < LEAST for own in report.learned.arms.values())
        same = len(arms) - len(changed) - few
        if same or not (few or changed):
            lines.append(f"  nothing changed on {counted(same, 'other arm' if changed else 'arm')}")
        if few:
            lines.append(f"  too few runs for a change on {counted(few, 'arm')}: {LEAST} at least")
    return [*lines, bound_words(found, rate), f"new: {counted(new, 'run')}"]


def _write_page(
    source: Source,
    store: Store,
    found: Sequence[KindReport],
    rate: float,
    unusable: Sequence[tuple[str, str]],
    marked: Sequence[tuple[str, str]],
) -> None:
    from exidyn.identification.pages.fleet_document import fleet_page

    links: dict[str, dict[str, str]] = {}
    for arm, row in last_runs(store).items():
        report = report_path(store, row)
        beside = quote(report.relative_to(store.folder).as_posix())
        links[arm] = {"report": beside} if report.exists() else {}
        links[arm]["last recording"] = (
            f"{source.address}/{row['file']}"
            if source.remote
            else (Path(source.address) / row["file"]).resolve().as_uri()
        )
    path = store.folder / PAGE
    write_whole(path, fleet_page(found, unusable, links, rate, marked))
    print_written(path)


def _compare(given: Namespace) -> None:
    first, second = given.what[1:]
    learned, found = differences(Store(given.output.resolve()), first, second)
    joints = learned.frame.kind.model.robot.joints
    lines = [f"{second} over {first}:", *(f"  {difference_words(one, joints)}" for one in found)]
    if not found:
        lines = [f"{first} and {second} do not differ beyond what one arm does from run to run"]
    table = {"exidyn_fleet": FORMAT, "differences": [one._asdict() for one in found]}
    hand_over("\n".join(lines), json_text(table), given.json)
