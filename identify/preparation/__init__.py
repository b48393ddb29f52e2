"""Preparation of a `Recording` for a fit: filtered `Motion`, decimated current, cut-offs, noise."""
