"""Keys of a robot.toml and their meanings: which keys are valid, and the comment above each."""

TITLES = {
    "[limits]": "Limits of the arm; planned motions and runs stay within them.",
    "[drive]": "Conversion of motor currents to joint torques.",
    "[flange]": "Mounting frame of payloads, in the last link's frame.",
    "[[link]]": "A joint, and the body that it moves. The keys of the other links have the same meaning.",
    "[[measurement]]": "Effects of the measurement on recordings; fits remove them.",
    "[prior]": "Single parameters: value, or [value, standard deviation].",
}
"""Table -> its meaning."""
KEYS: dict[str, dict[str, str]] = {
    "": {
        "format": "version of this format",
        "name": "name of the robot",
        "urdf": "path of a URDF or xacro file, beside this file",
        "mjcf": "path of an MJCF, beside this file",
        "mdh": "path of a modified Denavit-Hartenberg table, or rows [[mdh]]",
        "link": "rows [[link]]",
        "joints": "joints of the URDF or MJCF that move; the others are held",
        "held": "joints that are held, and their positions [rad; m]",
        "gravity": "in the base frame [m/s^2]; turn it for an arm on a wall or ceiling",
        "inertial_tolerance": "relative standard deviation of the links' masses and inertias",
        "rigid_body": "whether the links' inertia and gravity are in the model",
        "limits": "table [limits]",
        "drive": "table [drive]",
        "flange": "table [flange]",
        "prior": "table [prior]",
        "obstacle": "rows [[obstacle]]: solids around the arm",
        "region": "rows [[region]]: where points of the arm may be",
        "finding": "rows [[finding]]: what a diagnosis found",
        "effect": "rows [[effect]]",
        "measurement": "rows [[measurement]]",
    },
    "[limits]": {
        "degrees": "whether limits of position and velocity are in degrees",
        "position_lower": "minimum position [rad; m for a prismatic joint]",
        "position_upper": "maximum position [rad; m]",
        "velocity": "maximum velocity [rad/s; m/s]",
        "acceleration": "maximum acceleration [rad/s^2; m/s^2]",
        "jerk": "maximum jerk [rad/s^3; m/s^3]",
        "torque": "maximum torque of the joint [N m; N]",
        "velocity_lower": "minimum velocity, negative [rad/s; m/s]",
        "acceleration_lower": "minimum acceleration, negative [rad/s^2; m/s^2]",
    },
    "[drive]": {
        "gain": "joint torque per unit of current, with its sign [N m/A; N/A]",
        "gain_tolerance": "relative standard deviation of the gains",
        "gain_in_inertias": (
            "whether inertias were identified from currents with these gains: their errors are then "
            "correlated"
        ),
        "gear_ratio": "turns of the motor per turn of the joint [-]",
        "direct_drive": "joints whose motor has no gear",
        "passive": "joints without a motor: their torque is zero",
        "servo_gain": (
            "gain of position servos, for logs without currents: position error [rad] times this replaces "
            "the current, and gain is torque per unit of that; 1 if gain is in N m/rad"
        ),
        "servo_limit": "position error at which a servo saturates [rad]; inf: not known",
        "coupling": "motor velocity over gear ratio = coupling x joint velocity; identity: none [-]",
    },
    "[flange]": {
        "frame": "name of the flange; alone: of a link of the description that the last joint moves",
        "origin": "position of the flange [m]",
        "rotation": "rotation matrix of the flange [-]",
        "rpy": "roll, pitch and yaw of the flange [rad]",
    },
    "[[link]]": {
        "joint": "name of the joint",
        "link": "name of the link that it moves",
        "parent": 'joint whose link carries it; "": the base',
        "kind": '"revolute": turns, "prismatic": slides',
        "axis": "direction of the axis in the joint's frame [-]",
        "origin": "position of the joint's frame in the frame of the parent's link [m]",
        "rotation": "rotation matrix of the joint's frame in that frame [-]",
        "rpy": "roll, pitch and yaw of the joint's frame in that frame [rad]",
        "mass": "mass of the link [kg]",
        "center_of_mass": "center of mass in the joint's frame [m]",
        "inertia": "XX, XY, XZ, YY, YZ, ZZ about the center of mass [kg m²]",
    },
    "[[effect]]": {
        "name": "name of the effect; valid names are in docs/robot-toml.md",
        "values": "nominal values of its parameters",
        "tolerance": "relative standard deviation of the values",
        "std": "standard deviations of the values, in the same units",
        "joints": "names of the joints it acts on; default: all",
    },
    "[[measurement]]": {"name": "name of the measurement; valid names are in docs/robot-toml.md"},
    "[prior]": {},
}
"""Table -> key -> its meaning and unit; effects and measurements have fields as further keys."""
