"""Universal Robots CB3, e-Series and later by Real-Time Data Exchange, and a program that follows it."""
