"""Choice of the run that reduces the uncertainty of a diagnosis most per second.

Input: the search of a diagnosis, and planned or recorded runs on offer.
Output: the expected reduction of entropy by each run; the best run, or why no run is worthwhile.
"""
