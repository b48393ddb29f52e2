"""Test motion of one joint, and what it shows of the joint's sign, scale, gain and zero."""
