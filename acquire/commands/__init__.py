"""The commands, one file each.

In: their arguments.
Out: files, text, an exit code.
"""
