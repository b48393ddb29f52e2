"""Many arms, months of short runs.

In: a recording, and the type of its arm; then summaries of runs, by arm and date.
Out: a `Summary` a run; values, scatter, changes with dates, alarms; where two arms differ.
"""
