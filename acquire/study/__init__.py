"""A study: run after run, each chosen by what the ones before left open, until the model is decided.

In: a robot, a source of runs (a cell, or recordings that exist), a folder.
Out: in the folder, a round a run: motion, recording, fit, diagnosis, choice; and a notebook page.
"""
