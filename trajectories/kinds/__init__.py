"""Kinds of run other than the optimized one."""
