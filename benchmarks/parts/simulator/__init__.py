"""Arms in MuJoCo with physics that their files lack.

In: models of Menagerie.
Out: logs, and what is found in them.
"""
