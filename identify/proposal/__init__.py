"""What a log seems to hold: which column is what, in which unit, rough drive gains, and how sure that is."""
