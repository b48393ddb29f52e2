"""Files that commands read and write together.

In: paths.
Out: recordings, reports, traces.
"""
