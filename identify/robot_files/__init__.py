"""Reading and writing robot descriptions: `robot.toml`, URDF, MJCF, modified Denavit-Hartenberg tables.

Errors are a `RobotError`, whose message names the file, the key or element, its value, and what is valid.
"""
