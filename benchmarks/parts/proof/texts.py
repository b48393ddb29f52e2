"""What docs/proof.md says of each set, and of how names are counted."""

SETS = {
    "TX40": "Stäubli TX40, six joints, one run of 9 s at 1 kHz, joint torque (figaroh-examples). The last "
    "40 % are held out.",
    "KR300": "KUKA of the 300 kg class, motor torque, six runs of 10 s at 250 Hz on three days (Weigand "
    "and others); two are held out. A second encoder behind the gears of J1 to J3 shows how far they "
    "bend.",
    "KR300, links as drawn": "The same runs, with the masses of the CAD drawing stated to 10 %. The "
    "drawing lacks the gas counterbalance of J2; the tool is a payload of unknown mass.",
    "UR10e": "Motor currents at 100 Hz (Mamedov and Mikhel); two of seven runs, of other motions, are "
    "held out. Drive gains are published ones with a tolerance of 8 to 23 %.",
    "UR10e with a load": "A run with 2.805 kg on the flange that the model lacks. The prior is what "
    "exidyn identified from the five runs without it.",
    "Panda": "Franka Panda, 21 s at 1 kHz (Gaz and others, 2019), torque sensors behind the gears. A "
    "control: no effect stands out, so every name would be wrong.",
    "dVRK PSM": "Patient side manipulator of the dVRK, three cable-driven joints, 200 Hz (radiang). A "
    "control: no single term lowers the held-out residual by more than a few percent.",
    "EMPS": "A sliding axis with a ball screw, 1 kHz, force recorded (Janot, Gautier and Brunot, 2019). "
    "In its authors' second model, friction differs between the two directions.",
    "STS3215": "A Feetech servo that swings four weighed masses on an arm of 100 mm, 100 Hz, motor "
    "voltage (K-Scale Labs).",
    "XL330": "A Dynamixel servo that swings 0.49 kg on an arm of 100 mm at four position gains, 188 Hz, "
    "duty cycle (Rhoban).",
}
"""Title of a set -> machine and recordings. The sets of the motor have titles that say what they are."""

INTRODUCTION = """# Proof on real recordings

This page shows what `exidyn diagnose` names on public recordings of real arms, and what it misses. This
project made none of the recordings. They are not part of the repository; `EXIDYN_DATA` names their
folder. `python benchmarks/diagnose_real.py --pages docs/proof.md` writes this page and prints the
details of each set.

Each diagnosis starts from what a user has: a bare description without friction values, unstated
inertias, and filters chosen from the data (except in four rows of a motor). Every name of every set
counts.

* *known*: the experiment shows the effect without a diagnosis. It was switched off and on, weighed,
  measured by a second encoder, mapped by another method, published, or found by a plain fit with and
  without it.
* *named*: its probability is at least 90 %.
* *false*: the source excludes the name or would have reported it, or the set is a control.
* *size off*: the size is not within two standard deviations of the known one or the known range.
* *unverified*: nothing is known for or against the name.
* *again, nothing named*: a second diagnosis, with the model that was found (`found.toml`), names
  nothing. No model holds a hose, a sagging supply or a contact.
"""

SIMULATED = """## Simulated arms

[benchmarks/concealed.py](../benchmarks/concealed.py) conceals effects from the model of simulated arms,
simulates them by formulas of its own, and counts what is found: one, two or none, or one that exidyn
cannot model, from a third of the noise to ten times the noise. With `--bare`, the arms are diagnosed
without data-sheet values as well.
"""
