"""What stops a run.

In: samples, commands, signals, what a driver refuses.
Out: reasons to stop, and how hard.
"""
