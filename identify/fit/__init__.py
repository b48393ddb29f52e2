"""Identification.

Input: a model and prepared runs.
Output: `Fit` with base parameters, drive gains, covariance, residuals, and the identified model.
"""
