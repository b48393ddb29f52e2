"""Kinds of run beside the optimised one."""
