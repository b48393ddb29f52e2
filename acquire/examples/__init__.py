"""Examples of `exidyn example`: simulated arms, their commands, and the printed results."""
