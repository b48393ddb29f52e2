"""The paper's experiment on a simulated KR270: drive gains, spring balancer and dynamics together.

Two runs of 40 s follow the same random Fourier motion, without and with 175 kg of which only the mass is
given. Current noise is white, 1 % of each joint's rms current; encoders have 4e-6 rad steps and 1e-6 rad
noise. The nominal drive gains are the manufacturer's of Table III, 8 to 19 % off.
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one thread a process, and two processes

import numpy as np
from common import Kept, parser, save, show
from parts.kr270 import (
    BODY,
    CARRIED,
    CATALOGUE,
    SECONDS,
    Arm,
    coverage,
    edit_test_table,
    equations_of,
    gain_error,
    nominal,
    over_std,
    plant,
    record,
    true_base,
)

from exidyn.identification.fit.base_parameters import base_parameters
from exidyn.identification.fit.equations import Equations
from exidyn.identification.fit.estimators import ESTIMATORS, Estimate
from exidyn.identification.fit.identification import identify
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors

TABLE_III = {
    "ZZ1R": (1190, 0.63), "Fv1": (1090, 0.75), "Fc1": (301, 1.42), "XX2R": (-623, 1.38),
    "ZZ2R": (1510, 0.54), "MX2R": (344, 2.15), "Fv2": (2630, 1.28), "Fc2": (642, 3.01),
    "Off2": (-153, 1.98), "Kr": (50400, 3.9), "K0": (-78500, 2.1), "XX3R": (99.6, 5.6),
    "ZZ3R": (120, 3.2), "MX3R": (14.5, 3.3), "MY3R": (-102, 0.72), "Ia3": (680, 0.78),
    "Fv3": (102, 0.51), "Fc3": (402, 1.98), "Ia4": (170, 1.95), "Fv4": (526, 1.62), "Fc4": (185, 4.22),
    "Ia5": (209, 1.43), "Fv5": (845, 1.21), "Fc5": (199, 4.32), "Ia6": (131, 2.42), "Fv6": (782, 2.10),
    "Fc6": (3050, 5.56), "MZL": (-38.3, 1.81),
}  # fmt: skip
"""Identified values and relative standard deviations of the paper [SI, %]; Fc6 as printed."""
GAINS_III = ((-276, 1.15), (-427, 1.35), (-402, 1.23), (-295, 1.42), (-306, 1.25), (215, 1.32))
METHODS = ("literal", "ml")
KEYS = {"literal": "tls_literal"}
"""What the figures call an estimator, where it is not by its own name."""
QUICK_ARMS, ARMS = 10, 100
QUICK_SECONDS = 12.0
"""Length of a run with --quick [s]."""


def gains(equations: Equations) -> dict[str, Estimate]:
    """Every estimator beside the truth and the paper."""
    estimates = {name: ESTIMATORS[name](equations) for name in METHODS}
    header = ["drive gain error [%]", *(f"J{j + 1}" for j in range(6)), "K_r/std", "K_0/std"]
    rows = [["catalogue", *(100 * (CATALOGUE / plant().robot.drive_gain - 1)), np.nan, np.nan]]
    for name, e in estimates.items():
        rows.append([name, *gain_error(e), *(over_std(e, equations, k) for k in ("Kr", "K0"))])
        rows.append(["  its std", *(100 * e.gain_std / np.abs(e.gain)), np.nan, np.nan])
    show("Drive gains, and errors of K_r and K_0 over their standard deviations", header, rows)
    return estimates


def paper_table(equations: Equations, estimates: dict[str, Estimate]) -> None:
    """The paper's Table III with a column an estimator."""
    header = ["parameter", "paper", "std %", "true", *(x for m in METHODS for x in (m, "std %"))]
    rows = []
    for joint, (value, percent) in enumerate(GAINS_III):
        row = [f"g{joint + 1} [N m/A]", value, percent, plant().robot.drive_gain[joint]]
        for e in estimates.values():
            row += [e.gain[joint], 100 * e.gain_std[joint] / abs(e.gain[joint])]
        rows.append(row)
    truth = true_base(equations)
    for name, (value, percent) in TABLE_III.items():
        place = equations.names.index(name)
        row = [f"{name} [{equations.base.units[place]}]", value, percent, truth[place]]
        for e in estimates.values():
            row += [e.values[place], 100 * e.std[place] / abs(e.values[place])]
        rows.append(row)
    show("The paper's Table III and the same from simulated runs", header, rows)


def edit_test(estimates: dict[str, Estimate]) -> dict[str, Any]:
    """The payload put on and taken off, with gains of the catalogue and with those found."""
    unloaded, weighed = record(0, Sensors())
    [other] = record(1, Sensors(), motion=1)[:1]
    loaded, fits = replace(weighed, payload=KnownPayload("L", BODY)), {}
    for label, gain in (("catalogue", CATALOGUE), ("found", estimates["ml"].gain)):
        model = nominal(BODY)
        model = replace(model, robot=replace(model.robot, drive_gain=gain))
        fits[f"put on, gains {label}"] = identify([unloaded], [other, loaded], model=model, as_recorded=True)
        fits[f"taken off, gains {label}"] = identify([loaded], [other], model=model, as_recorded=True)
    return edit_test_table("Edit test, nothing fitted again", fits)


def literal_and_its_cure() -> dict[str, np.ndarray]:
    """Literal total least squares against maximum likelihood as noise and bandwidth grow."""
    figures, rows = {}, []
    for text, sensors, filtering in (
        ("1 % of rms, filters from the data", Sensors(), None),
        ("1 % of rms, the paper's 20 Hz", Sensors(), Filtering(position_cutoff=40, torque_cutoff=20)),
        ("4 % of rms, 20 Hz", Sensors(0.04), Filtering(position_cutoff=40, torque_cutoff=20)),
    ):
        equations = equations_of(record(0, sensors), filtering)
        for name in METHODS:
            estimate = ESTIMATORS[name](equations)
            rows.append([text, name, *gain_error(estimate), over_std(estimate, equations, "Kr")])
            figures[f"{name}, {text}"] = gain_error(estimate)
    header = ["current noise, band", "estimator", *(f"J{j + 1} %" for j in range(6)), "K_r/std"]
    show("Unweighted total least squares fails as noise grows; maximum likelihood does not", header, rows)
    return figures


def balancer_motion(swings: Sequence[float], motions: Sequence[int]) -> dict[str, list[float]]:
    """Standard deviation of K_r and K_0 against the swing of joint 2, and why."""
    rows: list[list[float]] = []
    for swing in swings:
        for motion in motions:
            runs = record(0, Sensors(), swing, motion=motion)
            reached = float(np.ptp(runs[0].signals["position"].values[:, 1]))
            if any(row[:2] == [reached, float(motion)] for row in rows):
                continue  # the velocity limit, not the range, holds this motion back
            equations = equations_of(runs)
            estimate = ESTIMATORS["ml"](equations)
            place = [equations.names.index(k) for k in ("Kr", "K0", "MX2R")]
            covariance = estimate.covariance[np.ix_(place, place)]
            std = np.sqrt(np.diag(covariance))
            correlation = covariance / np.outer(std, std)
            percent = 100 * std / np.abs(estimate.values[place])
            rows.append([reached, float(motion), *percent[:2], correlation[0, 1], correlation[0, 2]])
    header = ["swing of q2 [rad]", "motion", "K_r std %", "K_0 std %", "corr(K_r, K_0)", "corr(K_r, MX2R)"]
    show(
        "What the balancer needs: over a short swing of joint 2 its length hardly changes, so that\n"
        "stiffness, preload and the weight of link 2 give the same torque (the paper: 3.9 % and 2.1 %)",
        header,
        rows,
    )
    return {"swing": [r[0] for r in rows], "k_r_std_percent": [r[2] for r in rows]}


def show_coverage(name: str, count: int, seconds: float, kept: Path | None) -> dict[str, float]:
    """Share of the 95 % intervals that hold the truth [%], over arms drawn around one by its name."""
    figures = coverage([Arm(name, number, seconds) for number in range(count)], Kept(kept))
    rows = [[key.replace("_", " "), value] for key, value in figures.items()]
    show(f"Truth inside 95 % intervals, {count} arms drawn around the {name}", ["of", "%"], rows)
    return figures


def paper(quick: bool) -> dict[str, Any]:
    """The paper's experiment, and what noise, bandwidth and motion do to it."""
    equations = equations_of(record(0, Sensors()))
    inertial = sum(
        name[:2] in ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ") for name in equations.names
    )
    print(
        f"{len(equations.names)} base parameters of arm and payload, {inertial} of them inertial; "
        "the paper's 66 are the arm's 60 and six drive gains"
    )
    estimates = gains(equations)
    paper_table(equations, estimates)
    return {
        "gain_error_percent": {KEYS.get(m, m): gain_error(e) for m, e in estimates.items()},
        "gain_std_percent": {KEYS.get(m, m): 100 * e.gain_std / np.abs(e.gain) for m, e in estimates.items()},
        "k_r_error_over_std": over_std(estimates["ml"], equations, "Kr"),
        "k_0_error_over_std": over_std(estimates["ml"], equations, "K0"),
        "base_parameters_of_arm": len(base_parameters(read_model("kr270")).kept),
        "edit_test": edit_test(estimates),
        "literal": literal_and_its_cure(),
        "balancer": balancer_motion(*((0.3, 1.0), (0,)) if quick else ((0.15, 0.3, 0.6, 1.0), (0, 1))),
    }


def main() -> None:
    described = parser(__doc__.splitlines()[0])
    described.add_argument("--arm", choices=list(CARRIED), default="kr270", help="cobot: coverage alone")
    described.add_argument("--arms", type=int, metavar="N", help=f"to draw; default: {ARMS}")
    described.add_argument(
        "--resume", type=Path, metavar="FILE", help="keeps each arm, and those that it has"
    )
    chosen = described.parse_args()
    figures = paper(chosen.quick) if chosen.arm == "kr270" else {}
    count, seconds = (QUICK_ARMS, QUICK_SECONDS) if chosen.quick else (ARMS, SECONDS)
    figures |= show_coverage(chosen.arm, chosen.arms or count, seconds, chosen.resume)
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
