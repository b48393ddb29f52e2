"""What a joint may do, and whether a trajectory keeps to it."""
