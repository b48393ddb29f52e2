"""Payloads of known mass on simulated and real arms."""
