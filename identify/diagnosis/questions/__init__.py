"""What a candidate would add to a prediction: gain, coefficients, odds by block and joint."""
