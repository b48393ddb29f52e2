"""Settings that reach the peer of a Universal Robots controller."""


def ur_settings(address):
    """By what it printed after "ready": host, and the ports of RTDE, programs and dashboard."""
    host, *ports = address.split()
    names = ("rtde_port", "program_port", "dashboard_port")
    return {"address": host, **dict(zip(names, map(int, ports), strict=True))}
