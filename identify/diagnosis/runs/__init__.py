"""Runs as the diagnosis asks of them: torque and load at every sample, rows and columns."""
