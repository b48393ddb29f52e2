"""The search for what is missing: findings, their alternatives, and the prediction with them."""
