"""What has to hold in every run, and in one that bears its fault."""

from exidyn.drivers import StopLevel

from ..checks import all_recorded, goes_on, no_jump, time_goes_on

BRAKE, QUICK = StopLevel.BRAKE, StopLevel.QUICK
ALWAYS = (all_recorded, no_jump, time_goes_on)
BORNE = (*ALWAYS, goes_on)
FEW = 100
"""Cycles that a busy machine may miss by itself in some seconds: 5 %, which a run bears elsewhere."""
