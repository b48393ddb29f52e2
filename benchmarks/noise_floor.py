"""Whether the nominal model explains the sample cases to their noise, and in which joints it does not.

The nominal model is fitted with its priors, drive gains included, to the
runs of a case that are not held out, and compared with the `validate` run. The noise floor is measured
where the arm rests before it moves. Over some 1.5 to 3 s of rest at 15 Hz, that is 45 to 90 degrees of
freedom, the floor itself is uncertain to about a tenth: a ratio of 1.3 is exceeded by chance about once
in a hundred joints.
"""

import os
from pathlib import Path

import numpy as np
from common import options, save, show

from exidyn.identification.fit.estimators import posterior
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.importers import import_source

CASES = Path(os.environ.get("EXIDYN_CASES", Path(__file__).parents[1] / "../shared/cases"))
LIMIT = 1.3


def fit_case(folder: Path) -> Fit:
    """Fit the nominal model to a case; its `validate` run is held out."""
    runs = import_source(folder)
    used = [run for run in runs if run.settings["role"] != "validate"]
    held_out = [run for run in runs if run.settings["role"] == "validate"]
    return identify(used, held_out, estimator=posterior, drop=False)


def gain_from_prior(fit: Fit) -> np.ndarray:
    """How far each drive gain left its prior, in the prior's standard deviations."""
    robot = fit.model.robot
    return (fit.estimate.gain / robot.drive_gain - 1) / robot.drive_gain_tolerance


def main() -> None:
    chosen = options(__doc__.splitlines()[0])
    folders = sorted(path for path in CASES.glob("s[0-9]*") if path.is_dir())
    if not folders:
        print(f"no sample cases in {CASES}; set EXIDYN_CASES to their folder")
        save(chosen.json, {"skipped": "no sample cases"})
        return
    fits = {folder.name: fit_case(folder) for folder in folders}
    ratios = {name: fit.validation[0].over_noise for name, fit in fits.items()}
    joints = max(len(ratio) for ratio in ratios.values())
    header = ["case", *(f"J{j + 1}" for j in range(joints)), f"joints above {LIMIT}"]
    rows, prior = [], []
    for name, ratio in ratios.items():
        above = [f"J{j + 1}" for j in np.flatnonzero(ratio > LIMIT)]
        padding = [np.nan] * (joints - len(ratio))
        rows.append([name, *np.round(ratio, 2), *padding, ", ".join(above) or "none"])
        prior.append([name, *np.round(gain_from_prior(fits[name]), 1), *padding])
    show("Residual of the validate run over the noise floor", header, rows)
    show("Drive gain minus prior, over the prior's tolerance", header[:-1], prior)
    figures = {
        "residual_over_noise": ratios["s1"],
        "residual_over_noise_by_case": ratios,
        "joints_above": {name: np.flatnonzero(ratio > LIMIT) + 1 for name, ratio in ratios.items()},
    }
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
