"""Files that describe a robot, in and out: URDF, modified Denavit-Hartenberg tables, `robot.toml`."""
