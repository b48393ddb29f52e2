"""Logs as labs have them, and the way from each to a fit.

In: public data sets, and files written by other people's libraries.
Out: what was imported, guessed wrong, and said twice but not the same.
"""
