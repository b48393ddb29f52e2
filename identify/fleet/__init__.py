"""Monitoring of many arms by short runs over months.

In: a recording and the type of its arm; then summaries of runs, by arm and date.
Out: a `Summary` of each run; values, scatter, changes with dates, alarms; differences between two arms.
"""
