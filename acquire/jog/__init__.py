"""One joint a little way and back, and what that shows of its sign, scale, gain and zero."""
