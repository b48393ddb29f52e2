"""Identification.

In: a model and prepared runs.
Out: `Fit`: base parameters, gains, covariance, residuals; the model that was identified.
"""
