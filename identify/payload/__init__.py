"""The payload on the flange: mass, center of mass and inertia from a run that carries it.

In: a run with the payload; what is known of the arm, as a fit, a run without the payload, or a description.
Out: `PayloadEstimate`, with intervals, a check on poses that were not used, and the forms of controllers.
"""
