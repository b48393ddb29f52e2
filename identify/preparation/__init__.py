"""From a recording to what can be fitted.

In: `Recording`.
Out: filtered `Motion`, decimated current, cut-off frequencies, noise.
"""
