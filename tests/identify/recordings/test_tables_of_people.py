"""Tables as people have them: headers, units, numbers, dates and missing values in any usual form."""

import numpy as np
import pytest

from exidyn.identification.errors import BadUnit, NotFinite, WrongShape
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.tables.table import read_csv

from ...parts.runs.runs import TIME, model, motion, noise, require, table

USUAL = "t,q1,q2,tau1,tau2"


def run_of(path, text="", **options):
    if text:
        path.write_text(text, encoding="utf-8")
    [found] = import_source(path, model(), **options)
    return found


def rows(separator=",", decimal=".", time=TIME, scale=1.0):
    """Lines of the usual run."""
    values = np.column_stack([time, scale * motion(), noise()])
    return [separator.join(f"{value:.9f}" for value in row).replace(".", decimal) for row in values.tolist()]


def require_usual(found, degrees=False):
    expected = np.radians(motion()) if degrees else motion()
    require(found, position=expected, torque=noise(), atol=1e-8)
    require(found, time=TIME, atol=1e-6)


@pytest.mark.parametrize(
    "names",
    [
        "TIME,Q1,Q2,Tau1,TAU2",
        "Time,J1 Position,J2 Position,J1 Torque,J2 Torque",
        " t , q_1 , q_2 , tau[1] , tau[2] ",
        '"Time [s]","q1 [rad]","q2 [rad]","tau1 (Nm)","tau2 (N m)"',
        "time_s,q0,q1,tau0,tau1",
        "Zeit,Winkel A1,Winkel A2,Drehmoment A1,Drehmoment A2",
        "log/time,log/arm/q1,log/arm/q2,log/arm/tau1,log/arm/tau2",
        "__time,/js/axis1/position,/js/axis2/position,/js/axis1/effort,/js/axis2/effort",
    ],
)
def test_names_in_any_spelling(tmp_path, names):
    require_usual(run_of(tmp_path / "run.csv", "\n".join([names, *rows()])))


@pytest.mark.parametrize(
    "above",
    [
        ["# recorded by hand", "# on Monday", USUAL],
        ["sep=,", USUAL],
        ["Robot: small", "Operator: A. B.", "", USUAL],
        ["\ufeff" + USUAL],
        [USUAL, "s,rad,rad,Nm,Nm"],
        [USUAL, "[s],[rad],[rad],[N m],[N m]", ""],
    ],
)
def test_lines_around_the_names(tmp_path, above):
    require_usual(run_of(tmp_path / "run.csv", "\n".join([*above, *rows()])))


@pytest.mark.parametrize("skip", [0, 1])
def test_a_row_of_units_is_applied(tmp_path, skip):
    names = USUAL.replace(",", ";")
    text = "\n".join([names, "ms;deg;deg;mNm;mNm", *rows(";", ",", 1e3 * TIME)])
    found = run_of(tmp_path / "run.csv", text, skip_rows=skip)
    require(found, position=np.radians(motion()), torque=1e-3 * noise(), atol=1e-8)
    require(found, time=TIME, atol=1e-6)


def test_units_in_names_are_applied_and_a_preset_is_stronger(tmp_path):
    text = "\n".join(["time_ms,q1 [deg],q2 [deg],i1_mA,i2_mA", *rows(",", ".", 1e3 * TIME)])
    found = run_of(tmp_path / "run.csv", text)
    require(found, position=np.radians(motion()), current=1e-3 * noise(), atol=1e-8)
    require(found, time=TIME, atol=1e-6)
    (tmp_path / "preset.toml").write_text('[position]\ncolumn = "q{number} [deg]"\nunit = "rad"\n')
    np.testing.assert_allclose(run_of(tmp_path / "run.csv").signals["position"].values, motion(), atol=1e-8)


def test_a_unit_of_another_quantity_is_a_warning_and_per_cent_is_asked_about(tmp_path):
    text = "\n".join(["t,q1,q2,tau1 [Nm],tau2 [Nm]", *rows()])
    found = run_of(tmp_path / "run.csv", text, columns={"current": ["tau1", "tau2"]})
    require(found, current=noise(), atol=1e-8)
    assert any("tau1 [Nm] is in Nm, which is no unit of A" in warning for warning in found.warnings)
    with pytest.raises(BadUnit, match=r"q1 \[%\] is in %, which does not say of what"):
        run_of(tmp_path / "run.csv", "\n".join(["t,q1 [%],q2 [%],tau1,tau2", *rows()]))


@pytest.mark.parametrize(
    "form",
    [
        "%Y-%m-%dT%H:%M:%S.%f",
        "%Y-%m-%d %H:%M:%S.%fZ",
        "%Y-%m-%dT%H:%M:%S.%f+01:00",
        "%d.%m.%Y %H:%M:%S.%f",
        "%m/%d/%Y %I:%M:%S.%f %p",
        "%H:%M:%S.%f",
        "%M:%S.%f",
    ],
)
def test_dates_and_times_of_day_are_time(tmp_path, form):
    begin = np.datetime64("2026-03-14T23:59:59.900", "us")
    stamps = (begin + np.round(1e6 * TIME).astype("timedelta64[us]")).tolist()
    lines = [
        f"{stamp.strftime(form)},{row.split(',', 1)[1]}" for stamp, row in zip(stamps, rows(), strict=True)
    ]
    require_usual(run_of(tmp_path / "run.csv", "\n".join([USUAL, *lines])))
    assert read_csv(tmp_path / "run.csv")[0].units == {"t": "date"}


@pytest.mark.parametrize(("unit", "scale"), [("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_stamps_since_1970_have_the_unit_that_their_year_shows(tmp_path, unit, scale):
    stamps = [f"{round((1_772_444_467 + time) * scale)}" for time in TIME]
    lines = [f"{stamp},{row.split(',', 1)[1]}" for stamp, row in zip(stamps, rows(), strict=True)]
    found = run_of(tmp_path / "run.csv", "\n".join([USUAL, *lines]))
    require_usual(found)
    assert any(
        f"read as {unit} since 1970, the first as 2026-03-02 09:41:07" in word for word in found.warnings
    )


@pytest.mark.parametrize("word", ["", "NaN", "inf", "NULL", "#N/A", "-"])
def test_rows_without_a_joint_are_left_out_and_counted(tmp_path, word):
    lines = rows()
    for row in (3, 4, 50):
        cells = lines[row].split(",")
        lines[row] = ",".join([*cells[:4], word])
    lines[80] = ",".join([lines[80].split(",")[0], *4 * [word]])
    found = run_of(tmp_path / "run.csv", "\n".join([USUAL, *lines]))
    kept = np.delete(np.arange(len(TIME)), [3, 4, 50, 80])
    require(found, torque=noise()[kept], position=np.delete(motion(), 80, axis=0), atol=1e-8)
    assert "torque: no number for axis2 in 3 of 200 rows; these 3 rows are left out" in found.warnings


def test_rows_without_time_are_left_out_and_joints_must_share_rows(tmp_path):
    lines = rows()
    lines[7] = "," + lines[7].split(",", 1)[1]
    found = run_of(tmp_path / "run.csv", "\n".join([USUAL, *lines]))
    assert len(found.signals["position"]) == len(TIME) - 1
    assert "1 of 200 rows have no time, first line 9; they are left out" in found.warnings
    lines = [
        ",".join([*row.split(",")[:3], *(("1", "") if k % 2 else ("", "1"))]) for k, row in enumerate(rows())
    ]
    with pytest.raises(
        NotFinite, match="torque: no number for axis1 in 100, axis2 in 100 of 200 rows, and 0 with"
    ):
        run_of(tmp_path / "run.csv", "\n".join([USUAL, *lines]))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("t;q1\n0;1.014,35\n1;-2,5\n", [[0, 1014.35], [1, -2.5]]),
        ("t\tq1\n0\t1,234.5\n1\t12,345\n", [[0, 1234.5], [1, 12345]]),
        ('t,q1\n"0","1,234.5"\n"1","2.5"\n', [[0, 1234.5], [1, 2.5]]),
        ("t;q1;;\n0;1,5;;\n1;2;;\n", [[0, 1.5], [1, 2]]),
        ("t;q1\n0;1,5;\n1;2;\n", [[0, 1.5], [1, 2]]),
        ("t | q1\n0 | 1.5\n1 | 2\n", [[0, 1.5], [1, 2]]),
        ("t q1\n0 1.5 # bump\n# pause\n1 2\n", [[0, 1.5], [1, 2]]),
    ],
)
def test_numbers_in_any_form(tmp_path, text, expected):
    (tmp_path / "run.csv").write_text(text)
    [found] = read_csv(tmp_path / "run.csv")
    assert found.names == ["t", "q1"]
    assert found.values.tolist() == expected


@pytest.mark.parametrize("encoding", ["utf-16", "cp1252", "utf-8-sig"])
def test_encodings_of_spreadsheets(tmp_path, encoding):
    names = "t;q1 [°];q2 [°];tau1;tau2"
    (tmp_path / "run.csv").write_bytes("\r\n".join([names, *rows(";", ",")]).encode(encoding))
    require_usual(run_of(tmp_path / "run.csv"), degrees=True)


def test_names_of_groups_and_twins_are_not_guessed(tmp_path):
    path = table(tmp_path / "run.csv", "t,q1,q2,tau1,tau2,q1", motion(), noise(), noise()[:, 0])
    found = run_of(path)
    require(found, position=motion())
    assert "position: two columns are called q1; the first is read, q1.1 is not" in found.warnings
    np.savez(tmp_path / "run.npz", **{f"{arm}/q": motion() for arm in ("left", "right")}, t=TIME, tau=noise())
    with pytest.raises(
        WrongShape, match="no column q1, q2 for position. Columns: left/q1, left/q2, right/q1"
    ):
        run_of(tmp_path / "run.npz")
    found = run_of(tmp_path / "run.npz", columns={"position": "right/q"})
    require(found, position=motion())
    arrays = {"arm/q": motion(), "arm/i": noise(), "ft/torque": noise(2, 1), "target/velocity": motion()}
    np.savez(tmp_path / "run.npz", time=TIME, **arrays)
    assert set(run_of(tmp_path / "run.npz").signals) == {"position", "current", "command_velocity"}


def two_arms(path):
    arrays = {"qpos": motion(6), "effort": noise(6), "qvel": noise(6, 2)}
    np.savez(path, **{f"observations/{name}": values for name, values in arrays.items()}, action=motion(6))
    return path


def test_an_array_of_two_arms_is_asked_about_and_one_answer_is_enough(tmp_path):
    path = two_arms(tmp_path / "episode.npz")
    question = (
        r"observations/qpos has 6 columns for 2 joints \(axis1, axis2\): which\? For example 1 to 2, or "
        r"4 to 5: --columns position=observations/qpos1..2, or position=observations/qpos4..5"
    )
    with pytest.raises(WrongShape, match=question):
        run_of(path, rate=250)
    found = run_of(path, rate=250, columns={"position": "observations/qpos4..5"})
    expected = {"position": motion(6), "torque": noise(6), "velocity": noise(6, 2), "command": motion(6)}
    for signal, values in expected.items():
        assert np.array_equal(found.signals[signal].values, values[:, 3:5]), signal
