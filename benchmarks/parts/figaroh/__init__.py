"""FIGAROH behind the calls that the benchmarks need.

In: an arm, motions, torques.
Out: its regressor, its identification, its exciting trajectory, with the time they took.
"""
