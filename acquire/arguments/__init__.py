"""Arguments that several commands share.

In: the command line.
Out: settings, controllers, exit codes.
"""
