"""What must be asked of the driver, by fault and by the stage in which it begins."""

from typing import NamedTuple

from exidyn.drivers import StopLevel

WITHIN = {StopLevel.BRAKE: 0.6, StopLevel.QUICK: 0.5, StopLevel.OFF: 1.6}
"""From a fault to the first level, and from each level to the next, at most [s].

BRAKE: 0.15 s of a tracking error, and what an arm that approaches slowly takes to have one.
QUICK: 0.1 s in which the delay of drives and the mean of a speed end, 0.1 s to be sure, or a brake of 0.25 s
and 0.2 s for the error behind it.
OFF: 1.15 s in which a quick stop from full speed ends, or less and the 0.67 s of 0.2 rad at 0.3 rad/s, and
0.1 s to be sure.
"""

STAGES = ("listening", "approaching", "running", "braking", "holding", "quick stop")
"""In which a fault begins; in the fourth a person has asked for a brake, in the last for a quick stop."""

RESTS = 0.1
"""Speed below which an arm rests in the end [rad/s]."""


class Fault(NamedTuple):
    """What goes wrong.

    Attributes:
        name: In words.
        faults: As the mock gets them, with {at} for when.
        levels: What must be asked in each of `STAGES`: B for brake, Q for quick stop, O for off; "-" where it
            cannot be.
        coarse: Whether encoders are those of serial servos, and as noisy.
        rests: Whether the arm must rest in the end; without torque, and where nothing helps, it does not.
        quick: Stages that are shown in a hurry too.
        late: Time until a slow fault is a tracking error, beside `WITHIN` [s].
    """

    name: str
    faults: str
    levels: str
    coarse: bool = False
    rests: bool = True
    quick: tuple[str, ...] = ()
    late: float = 0.0


FAULTS = (
    # Sound arms are not escalated, whatever their encoders.
    Fault("none", "", ". . . B . Q"),
    Fault("none; coarse encoders", "", ". . . B . Q", coarse=True, quick=("running",)),
    # A drive that runs away, and what is left where it ignores the next level, or the driver fails at it.
    Fault("runaway", "runaway joint1 2 at {at}", "BQ BQ BQ BQ BQ Q", quick=("running", "braking")),
    Fault(
        "runaway; quick stop ignored",
        "runaway joint1 2 at {at}; deaf at start",
        "BQO BQO BQO BQO BQO QO",
        rests=False,
        quick=("running",),
    ),
    Fault(
        "slow runaway; quick stop ignored",
        "runaway joint1 0.3 at {at}; deaf at start",
        "BQO BQO BQO BQO BQO QO",
        rests=False,
    ),
    Fault(
        "creep; quick stop ignored",
        "runaway joint1 0.08 at {at}; deaf at start",
        "BQO BQO BQO BQO BQO QO",
        rests=False,
        quick=("quick stop",),
        late=0.035 / 0.08,
    ),
    Fault(
        "runaway; driver fails at QUICK",
        "runaway joint1 2 at {at}; stop fails at start",
        "BQO BQO BQO BQO BQO QO",
        rests=False,
        quick=("running",),
    ),
    Fault(
        "runaway; driver fails at all",
        "runaway joint1 2 at {at}; stop fails 3 at start",
        "BQO BQO BQO BQO BQO QO",
        rests=False,
    ),
    # Commands are added; where they rest, or are a millimetre's, nothing runs.
    Fault("commands are added", "additive at {at}", "BQ BQ BQ BQ . Q", quick=("approaching",)),
    # A joint that stays where it is must not lose its torque.
    Fault("joint stuck", "stuck joint1 at {at}", "BQ BQ BQ BQ . Q"),
    Fault("encoder slips by 0.3 rad", "jump joint1 0.3 at {at}", "BQ BQ BQ BQ BQ Q"),
    # These are quick stops at once, in every stage.
    Fault("drive fault", "fault joint1 at {at}", "Q Q Q BQ Q Q"),
    Fault("joint silent", "stale joint1 at {at}", "Q Q Q BQ Q Q"),
    Fault("not a number", "nan joint1 at {at} for 9", "Q Q Q BQ Q Q"),
    Fault("link lost", "silent at {at}", "- Q Q BQ Q Q", rests=False),
    # These are brakes, and no reason to stop harder.
    Fault("current too high", "current spike joint1 at {at} for 0.3", "B B B B B Q"),
    Fault("no cycle for 0.1 s", "stall 0.1 at {at}", ". B B B B Q"),
    Fault("two cycles without reply", "drop at {at} for 0.016", "- . . B . Q"),
)


class Case(NamedTuple):
    """One cell of the table.

    Attributes:
        fault: What goes wrong.
        stage: In which it begins.
        levels: What must be asked, in order, as letters.
        quick: Whether it is shown in a hurry too.
    """

    fault: Fault
    stage: str
    levels: str
    quick: bool


CASES = tuple(
    Case(fault, stage, levels.strip("."), stage in fault.quick)
    for fault in FAULTS
    for stage, levels in zip(STAGES, fault.levels.split(), strict=True)
    if levels != "-"
)
