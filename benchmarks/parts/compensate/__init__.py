"""What a feedforward leaves of the torque of public recordings, and what a call of it costs."""
