"""The live view of a run, in a process of its own.

In: frames.
Out: Rerun in a window, in browsers, in a file.
"""
