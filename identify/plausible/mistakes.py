"""Table of mistakes: the prior of each kind, its effect on a log, and the remedy.

A row is a kind of mistake. Its cases share the row's probability. Each case has a clause on what is wrong,
the change that corrects the log, and the joints concerned. A new hypothesis needs one row.
"""

from . import joint_mistakes as joints
from . import size_mistakes as sizes
from .joint_mistakes import Side
from .mistake import Mistake

GIVE = "swap them with --columns, or under column in the preset file"
ORDER = "give the columns in the robot's order"
TURN_BOTH = "reverse both: sign = -1 of position and effort in a preset, or the axis in the robot description"
TURN = "reverse it: sign = -1 in a preset, or the sign of [drive] gain, or the axis of the joint"
TURN_POSITION = "reverse it: [position] sign in a preset, or the axis in the robot description"
UNIT = "state it: exidyn import --degrees, or [position] unit in a preset; omit --degrees for radians"
TRAVEL = 'state it: [position] unit = "%" in a preset'
SCALE = "state it: [position] scale in a preset"
GEAR = "state it: [drive] gear_ratio in robot.toml, or scale in a preset"
STATE = "state it: [current] or [torque] unit in a preset, or [drive] gain"
GRAVITY = "state it: gravity in robot.toml"
NO_GRAVITY = "state it: gravity = [0, 0, 0] in robot.toml"
MOTOR_SIDE = "state [drive] gear_ratio in robot.toml, and import with --motor-side torque"
COUPLED = "state it: [drive] coupling in robot.toml, and import with --motor-side"
SERVO = "state it: [drive] gain in robot.toml"
CLOCK = "align the clocks of the two sources, or record both with one clock"

TABLE = (
    Mistake("joint_direction", 0.006, TURN_BOTH, joints.turned(Side.BOTH), of_sizes=True),
    Mistake("position_sign", 0.004, TURN_POSITION, joints.turned(Side.POSITION)),
    Mistake("effort_sign", 0.005, TURN, joints.turned(Side.EFFORT)),
    Mistake("two_effort_signs", 0.001, TURN, joints.turned(Side.EFFORT, 2)),
    Mistake("all_effort_signs", 0.005, TURN, sizes.all_turned),
    Mistake("exchanged_columns", 0.004, GIVE, joints.exchanged(Side.BOTH)),
    Mistake("exchanged_positions", 0.002, GIVE, joints.exchanged(Side.POSITION)),
    Mistake("exchanged_efforts", 0.002, GIVE, joints.exchanged(Side.EFFORT)),
    Mistake("order", 0.004, ORDER, joints.orders(Side.BOTH)),
    Mistake("order_of_positions", 0.001, ORDER, joints.orders(Side.POSITION)),
    Mistake("order_of_efforts", 0.001, ORDER, joints.orders(Side.EFFORT)),
    Mistake("exchanged_chains", 0.003, ORDER, joints.exchanged_chains),
    Mistake("sum_of_joints", 0.002, COUPLED, joints.sums(Side.BOTH)),
    Mistake("sum_of_positions", 0.002, COUPLED, joints.sums(Side.POSITION)),
    Mistake("sum_of_efforts", 0.001, COUPLED, joints.sums(Side.EFFORT)),
    Mistake("coupled_motors", 0.005, COUPLED, joints.coupled_motors),
    Mistake("differential", 0.001, COUPLED, joints.differentials(Side.BOTH)),
    Mistake("differential_positions", 0.001, COUPLED, joints.differentials(Side.POSITION)),
    Mistake("differential_efforts", 0.0005, COUPLED, joints.differentials(Side.EFFORT)),
    Mistake("position_unit", 0.005, UNIT, sizes.position_units),
    Mistake("percent_of_travel", 0.004, TRAVEL, sizes.shares_of_travel),
    Mistake("position_scale", 0.002, SCALE, sizes.position_scales),
    Mistake("gear_ratio", 0.002, GEAR, sizes.gear_ratios, of_sizes=True),
    Mistake("effort_unit", 0.012, STATE, sizes.effort_units),
    Mistake("effort_factor", 0.003, STATE, sizes.unknown_factors),
    Mistake("torque_constants", 0.004, STATE, sizes.torque_constants),
    Mistake("motor_side", 0.008, MOTOR_SIDE, sizes.motor_side),
    Mistake("servo_gain", 0.02, SERVO, sizes.servo_gains),
    Mistake("no_gravity", 0.004, NO_GRAVITY, sizes.no_gravity),
    Mistake("upside_down", 0.003, GRAVITY, sizes.upside_down),
)
"""All kinds of mistakes. Each prior is a judgment of their frequency; one log in ten has any mistake."""
MOUNTING = Mistake("mounting", 0.01, GRAVITY, lambda facts: iter(()))
"""Unlisted mounting: its direction requires a search, made only if the log does not fit."""
TWO_CLOCKS = Mistake("two_clocks", 0.004, CLOCK, lambda facts: iter(()))
"""Efforts with a clock of their own: delay and drift require a search, made only if the log does not fit."""
