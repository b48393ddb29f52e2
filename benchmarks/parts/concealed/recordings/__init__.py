"""What is recorded of a robot, and the files of a case.

In: a `Robot`, a plan of the run.
Out: `Run`; the folder of a case, its truth in a file of its own.
"""
