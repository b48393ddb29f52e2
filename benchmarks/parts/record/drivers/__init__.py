"""Every driver against its peer.

In: settings of a driver, a motion.
Out: lateness beside that of a bare loop (`table`), what is identified through each driver (`agreement`).
"""
