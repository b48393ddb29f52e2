"""Which run settles most per second of what a diagnosis leaves open.

In: the search of a diagnosis, runs on offer, planned or recorded.
Out: by how much each is expected to lower the entropy of what is open; the best, or why none does.
"""
