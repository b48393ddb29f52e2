"""How the loop hands a run over to processes of their own.

In: samples, commands, events.
Out: frames at the other end of a pipe.
"""
