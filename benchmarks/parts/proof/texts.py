"""What docs/proof.md says of each set, of the motor, and of how names are counted."""

from typing import NamedTuple


class About(NamedTuple):
    """A set on the page.

    Attributes:
        heading: Of its section.
        what: Machine and recordings, in sentences.
        unit: Of its misfit.
    """

    heading: str
    what: str
    unit: str = "N m"


ABOUT = {
    "tx40": About(
        "Stäubli TX40",
        "Six joints, one run of 9 s at 1 kHz, joint torque (figaroh-examples): the first 60 % fitted, the "
        "rest held out. Motor 6 turns with joints 5 and 6, and the sizes of that are published.",
    ),
    "kr300": About(
        "KUKA KR300",
        "Six joints, 300 kg class, six runs of 10 s at 250 Hz on three days (Weigand and others), motor "
        "torque: four fitted, two held out. A second encoder behind the gears of J1 to J3 shows by how "
        "much they bend, together with the 2.6 to 3.2 ms that lie between the two readings.",
    ),
    "kr300_drawn": About(
        "KUKA KR300 with its links as drawn",
        "The same runs; now the masses of the CAD drawing are stated to 10 %, which have neither the gas "
        "counterbalance of J2 nor the tool. The tool is given as a body of unknown mass. Without stated "
        "masses a balancer may be a mass.",
    ),
    "ur10e": About(
        "UR10e",
        "Six joints, motor currents at 100 Hz (Mamedov and Mikhel): five runs fitted, two of other "
        "motions held out. Drive gains are published ones, known to what two published sets differ by: 8 to "
        "23 %.",
    ),
    "ur10e_loaded": About(
        "UR10e with a weighed load that is not stated",
        "The prior is what exidyn identified from the five runs without a load. The run that is diagnosed "
        "has 2.805 kg on the flange; the one held out another motion with the same body. The masses are as "
        "wrong as the published drive gains, and so is that of the load.",
    ),
    "ur10e_calibrated": About(
        "UR10e with a weighed load that is not stated, drive gains calibrated",
        "The same, but the prior was identified with one more run, in which the arm carries another body of "
        "which the mass is known: that gives the drive gains.",
    ),
    "panda": About(
        "Franka Panda: a control",
        "Seven joints, 21 s at 1 kHz (Gaz and others, 2019), torque from sensors behind the gears, which "
        "hide most of what motors and gears do: two thirds fitted, one held out. Nothing stands out in "
        "it, so every name would be wrong.",
    ),
    "dvrk_psm": About(
        "dVRK patient side manipulator: a control",
        "Three joints driven by cables, one of them sliding, 200 Hz (radiang), effort: five runs of 30 s "
        "fitted, one held out. No term alone lowers its held-out residual by more than some per cent, so "
        "that every name counts as wrong.",
        "N m, N m, N",
    ),
    "emps": About(
        "EMPS: a sliding axis with a ball screw",
        "The benchmark of Janot, Gautier and Brunot (2019): 1 kHz, 25 s to fit and 25 s with pulses of "
        "force held out. Force is recorded. Its authors' second model brakes differently in the two "
        "directions.",
        "N",
    ),
    "kscale": About(
        "Feetech STS3215: a servo that swings weighed masses",
        "One joint, 100 Hz, four masses on an arm of 100 mm (K-Scale Labs), voltage on the motor: three "
        "motions with each mass fitted, one held out. Gravity on each is known from scales and ruler.",
    ),
    "bam_xl330": About(
        "Dynamixel XL330: a servo that swings a weighed mass",
        "One joint, 188 Hz, 0.49 kg on an arm of 100 mm at four position gains (Rhoban): duty of the motor's "
        "bridge, three gains fitted, the stiffest held out. In four runs torque is off after 2 s.",
    ),
}

INTRODUCTION = """# Proof on real recordings

`python benchmarks/diagnose_real.py --pages docs/proof.md` makes this page and its pictures. It diagnoses
public recordings not made by this project, with what a user has to begin with: a bare description,
no friction values, inertias not stated, filters chosen from the data but for four rows of a motor. The
recordings are not part of the repository (`EXIDYN_DATA` names their folder).

An effect is *known* if the experiment shows it without a diagnosis: it was switched off and on, weighed,
measured by a second encoder, mapped by another method, published, or found by a plain fit with and without
it, whose figures are given. It is *named* from a probability of 90 % on. A name is *false* if the source
excludes it or would have reported it (contact, delay, tilt, load; a gain where torque was recorded), or if
the set is a control. Its size is *off* if it is not the known one, or in the known range, within two of its
standard deviations. Other names are *unverified*: nothing is known for or against them. What is *undecided*
is in the fit without a name. Every name of every set counts, with the default filters and with given ones.
Each set is *diagnosed again* with the model that was found (`found.toml`): nothing should be named then. A
model holds no hose, no supply that sags and no contact. Misfit is the root
mean square of what the best fit without findings leaves of runs held out.
"""

SIMULATED = """## Simulated arms

Effects are concealed from the model of simulated arms: one, two, none, or one of which exidyn has no model,
of a third of the noise to ten times it. [benchmarks/concealed.py](../benchmarks/concealed.py) simulates
them by formulas of its own and counts what is found again. The arms have the values of a data sheet, with
tolerances; with `--bare` they are answered without them, too.
"""

MOTOR_WORDS = """\
One brushless motor without gear or load (ODrive; recordings of gchenfc, MIT), spun up and reversed. In one
state the drive adds a map of its cogging to the current; in the other it does not. The map is the current
that holds the motor still at 2048 angles: harmonics 7 (0.862 A), 28 (0.560 A), 14 (0.349 A), 36 (0.290 A)
and 12 (0.263 A) of its turn. The set current contains the ripple with compensation off, and is nearly
without it with compensation on, as the drive adds the map afterwards; the measured current contains it in
both states. A fit with given harmonics leaves 0.38 A of harmonic 7 in the set current with compensation on,
out of line with the map. Set current, the same cut-offs in both states (torque 60 Hz, position 80 Hz):"""

OPEN_LOOP = """\
Models integrated from the recorded force alone, with nothing of the recorded motion but its first place:
error of the position, root mean square [mm]. The page that comes with the recordings has 6.75 and 9.20 for
the published parameters, by another integration."""
