"""Stops of a run: monitors, and escalation if a stop does not work."""
