"""Documents: what is said of a result, once, and its renderers, which know no physics."""
