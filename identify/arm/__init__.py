"""The rigid arm: `Robot`, `Motion`, and from them torques, regressors and their gradients."""
