"""Table of mistakes: the prior of each kind, its effect on a log, and the remedy.

A row is a kind of mistake. Its cases share the row's probability. Each case has a clause on what is wrong,
the change that corrects the log, and the joints concerned. A new hypothesis needs one row.
"""

from . import effort_mistakes as efforts
from . import position_mistakes as positions
from .mistake import Mistake

GIVE = "swap them with --columns, or under column in the preset file"
ORDER = "give the columns in the robot's order"
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
DESCRIBE = "check order, signs and axes of the joints, or give the description and gains of the recorded arm"
SERVO = "state it: [drive] gain in robot.toml"

TABLE = (
    Mistake("exchanged_columns", 0.004, GIVE, positions.exchanges(True, True, "all columns")),
    Mistake("exchanged_positions", 0.002, GIVE, positions.exchanges(True, False, "the positions")),
    Mistake("exchanged_efforts", 0.002, GIVE, positions.exchanges(False, True, "the efforts")),
    Mistake("order", 0.004, ORDER, positions.orders),
    Mistake("exchanged_chains", 0.003, ORDER, positions.exchanged_chains),
    Mistake("position_sign", 0.004, TURN_POSITION, positions.turned_positions, of_sign=True),
    Mistake("position_unit", 0.005, UNIT, positions.other_angles),
    Mistake("percent_of_travel", 0.004, TRAVEL, positions.shares_of_travel, always=True),
    Mistake("position_scale", 0.002, SCALE, positions.position_scales),
    Mistake("gear_ratio", 0.002, GEAR, positions.gear_ratios),
    Mistake("effort_sign", 0.005, TURN, efforts.turned_efforts(1), of_sign=True),
    Mistake("two_effort_signs", 0.001, TURN, efforts.turned_efforts(2), of_sign=True),
    Mistake("all_effort_signs", 0.005, TURN, efforts.all_turned, of_sign=True),
    Mistake("effort_unit", 0.01, STATE, efforts.effort_units),
    Mistake("one_effort_unit", 0.002, STATE, efforts.one_effort_unit),
    Mistake("unknown_effort_unit", 0.001, STATE, efforts.unknown_unit),
    Mistake("effort_group", 0.001, STATE, efforts.effort_groups),
    Mistake("drive_constant", 0.002, STATE, efforts.wrong_gears),
    Mistake("torque_constants", 0.004, STATE, efforts.torque_constants),
    Mistake("motor_side", 0.008, MOTOR_SIDE, efforts.motor_side),
    Mistake("servo_gain", 0.02, SERVO, efforts.servo_gains),
    Mistake("another_arm", 0.005, DESCRIBE, efforts.another_arm),
    Mistake("no_gravity", 0.004, NO_GRAVITY, efforts.no_gravity),
    Mistake("upside_down", 0.003, GRAVITY, efforts.upside_down, of_sign=True),
)
"""All kinds of mistakes. Each prior is a judgment of their frequency; one log in ten has any mistake."""
MOUNTING = Mistake("mounting", 0.01, GRAVITY, lambda facts: iter(()))
"""Unlisted mounting: its direction requires a search, made only if much is unexplained."""
