"""From a `Recording` to what can be fitted: filtered `Motion`, decimated current, cut-offs, noise."""
