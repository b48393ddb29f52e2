"""One session of telegrams with the controller.

In: datagrams.
Out: the newest telegram, and the answer to it.
"""
