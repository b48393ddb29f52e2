"""Files that describe a robot.

In: URDF, modified Denavit-Hartenberg tables, `robot.toml`, names of built-in robots.
Out: `Model`; and the text of such files.
"""
