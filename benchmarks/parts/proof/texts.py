"""What docs/proof.md says of each set, of the motor, and of how names are counted."""

from typing import NamedTuple


class About(NamedTuple):
    """A set on the page."""

    heading: str  # Of its section
    what: str  # Machine and recordings, in sentences
    unit: str = "N m"  # Of its misfit


ABOUT = {
    "tx40": About(
        "Stäubli TX40",
        "Six joints, one run of 9 s at 1 kHz, joint torque (figaroh-examples). The first 60 % are "
        "fitted, the rest is held out. Motor 6 turns with joints 5 and 6; the parameters of that "
        "coupling are published.",
    ),
    "kr300": About(
        "KUKA KR300",
        "Six joints, 300 kg class, six runs of 10 s at 250 Hz on three days (Weigand and others), motor "
        "torque. Four runs are fitted, two are held out. A second encoder behind the gears of J1 to J3 "
        "shows how far they bend, together with the 2.6 to 3.2 ms between the two readings.",
    ),
    "kr300_drawn": About(
        "KUKA KR300 with its links as drawn",
        "The same runs, with the masses of the CAD drawing stated to 10 %. The drawing has neither the "
        "gas counterbalance of J2 nor the tool; the tool is given as a payload of unknown mass. Without "
        "stated masses, a balancer could be a mass.",
    ),
    "ur10e": About(
        "UR10e",
        "Six joints, motor currents at 100 Hz (Mamedov and Mikhel). Five runs are fitted, two of other "
        "motions are held out. Drive gains are published ones with a tolerance of 8 to 23 %, the "
        "difference between two published sets.",
    ),
    "ur10e_loaded": About(
        "UR10e with a weighed load that is not stated",
        "The prior is what exidyn identified from the five runs without a load. The diagnosed run has "
        "2.805 kg on the flange; the run held out is another motion with the same payload. Masses have "
        "the relative error of the published drive gains, including that of the load.",
    ),
    "ur10e_calibrated": About(
        "UR10e with a weighed load that is not stated, drive gains calibrated",
        "The same, but the prior was identified with one more run, in which the arm carries another "
        "payload of known mass, which determines the drive gains.",
    ),
    "panda": About(
        "Franka Panda: a control",
        "Seven joints, 21 s at 1 kHz (Gaz and others, 2019), torque from sensors behind the gears, "
        "which hide most effects of motors and gears. Two thirds are fitted, one third is held out. No "
        "effect stands out, so every name would be wrong.",
    ),
    "dvrk_psm": About(
        "dVRK patient side manipulator: a control",
        "Three cable-driven joints, one of them prismatic, 200 Hz (radiang), effort. Five runs of 30 s "
        "are fitted, one is held out. No single term lowers the held-out residual by more than a few "
        "percent, so every name counts as wrong.",
        "N m, N m, N",
    ),
    "emps": About(
        "EMPS: a sliding axis with a ball screw",
        "The benchmark of Janot, Gautier and Brunot (2019): 1 kHz, force recorded, 25 s fitted, and 25 "
        "s with force pulses held out. In its authors' second model, friction differs between the two "
        "directions.",
        "N",
    ),
    "kscale": About(
        "Feetech STS3215: a servo that swings weighed masses",
        "One joint, 100 Hz, four masses on an arm of 100 mm (K-Scale Labs), motor voltage. Three "
        "motions with each mass are fitted, one is held out. The gravity torque of each mass is known "
        "from scales and ruler.",
    ),
    "bam_xl330": About(
        "Dynamixel XL330: a servo that swings a weighed mass",
        "One joint, 188 Hz, 0.49 kg on an arm of 100 mm at four position gains (Rhoban), duty cycle of "
        "the motor's bridge. Three gains are fitted, the highest is held out. In four runs, torque is "
        "off after 2 s.",
    ),
}

INTRODUCTION = """# Proof on real recordings

This page shows what `exidyn diagnose` names on public recordings of real arms, and what it misses. None
of the recordings was made by this project. They are not part of the repository; `EXIDYN_DATA` names
their folder. `python benchmarks/diagnose_real.py --pages docs/proof.md` writes this page.

Each diagnosis starts from what a user has: a bare description without friction values, unstated
inertias, and filters chosen from the data (except in four rows of a motor). Every name of every set
counts, with the default filters and with given ones.

* *known*: the experiment shows the effect without a diagnosis. It was switched off and on, weighed,
  measured by a second encoder, mapped by another method, published, or found by a plain fit with and
  without it, whose figures are given.
* *named*: its probability is at least 90 %.
* *false*: the source excludes the name or would have reported it (contact, delay, tilt, load; a gain if
  torque was recorded), or the set is a control.
* *size off*: the size is not within two standard deviations of the known one or the known range.
* *unverified*: nothing is known for or against the name.
* *undecided*: the effect is in the fit without a name.
* *diagnosed again*: with the model that was found (`found.toml`), nothing should be named. A model holds
  no hose, no sagging supply and no contact.
* *misfit*: residual of the best fit without findings on runs held out, root mean square.
"""

SIMULATED = """## Simulated arms

[benchmarks/concealed.py](../benchmarks/concealed.py) conceals effects from the model of simulated arms:
one, two, none, or one that exidyn cannot model, from a third of the noise to ten times the noise. It
simulates them by formulas of its own and counts what is found. The arms have data-sheet values with
tolerances; with `--bare`, they are diagnosed without these values as well.
"""

OPEN_LOOP = """\
Position error [mm, root mean square] of models integrated from the recorded force alone, starting at the
first recorded position. The page that comes with the recordings has 6.75 and 9.20 for the published
parameters, by another integration."""
