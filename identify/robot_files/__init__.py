"""Reading and writing robot descriptions: `robot.toml`, URDF, MJCF, modified Denavit-Hartenberg tables."""
