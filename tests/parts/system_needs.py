"""What tests need that pip does not install. A test looks for it, or skips and names the Debian package.

    python3 tests/parts/system_needs.py        prints the packages that this machine lacks, for .ci/run

That runs before anything is installed: this file needs only the standard library, and pytest where it skips.
"""

import ctypes
import os
import re
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

GROUP = "ff11::1"
"""Multicast group of the probe; its scope is interface-local, so that nothing leaves the machine."""
PATIENCE = 5.0
"""Longest wait for a datagram that this machine sends to itself [s]; it takes some microseconds."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@dataclass(frozen=True)
class Need:
    """Something that tests need from the operating system."""

    packages: tuple[str, ...]  # debian packages that bring it; empty where no package does
    problem: Callable[[], str]  # returns why this machine cannot offer it, or an empty text

    @property
    def reason(self) -> str:
        """Why a test skips, with the command that helps; empty if the machine has what the test needs."""
        problem = self.problem()
        remedy = f"; apt-get install {' '.join(self.packages)}" if self.packages else ""
        return problem and problem + remedy

    def require(self) -> None:
        """Skip the test that runs if the machine lacks this."""
        if reason := self.reason:
            import pytest

            pytest.skip(reason)


def program_problem(*names: str) -> str:
    """Names the programs of which none is on the path."""
    return "" if any(map(shutil.which, names)) else f"no program {' or '.join(names)}"


def browser() -> str:
    """Path of a browser that the DevTools protocol drives."""
    return next(filter(None, map(shutil.which, BROWSERS)))


@cache
def vulkan_problem() -> str:
    """Whether Vulkan's loader finds no device, asked in a child process, which a broken driver may crash."""
    if sys.platform != "linux":
        return ""  # macOS draws with Metal
    command = [sys.executable, __file__, "--vulkan-devices"]
    listing = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    drawable = listing.stdout.strip() not in ("", "0")
    return "" if drawable else "no Vulkan driver, and Rerun's viewer does not draw without"


def vulkan_devices() -> int:
    """Number of devices that Vulkan's loader offers, by the drivers that its environment variables select."""
    try:
        vulkan = ctypes.CDLL("libvulkan.so.1")
    except OSError:
        return 0
    instance, count = ctypes.c_void_p(), ctypes.c_uint32()
    create_info = (ctypes.c_uint32 * 16)(1)  # VkInstanceCreateInfo: its type is 1, other fields are unset
    if vulkan.vkCreateInstance(create_info, None, ctypes.byref(instance)):
        return 0
    vulkan.vkEnumeratePhysicalDevices(instance, ctypes.byref(count), None)
    return count.value


@cache
def sdformat() -> str:
    """Name of libsdformat for pkg-config, such as sdformat12; empty where it is not installed."""
    if not shutil.which("pkg-config"):
        return ""
    listed = subprocess.run(["pkg-config", "--list-all"], capture_output=True, text=True).stdout
    versions = [int(version) for version in re.findall(r"^sdformat(\d+)\s", listed, re.MULTILINE)]
    return f"sdformat{max(versions)}" if versions else ""


def sdformat_problem() -> str:
    if problem := program_problem("pkg-config") or program_problem("g++"):
        return problem
    return "" if sdformat() else "no libsdformat, which reads URDF as Gazebo does"


@cache
def multicast_problem() -> str:
    """Why a multicast datagram does not come back."""
    try:
        with socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as end:
            end.bind(("::", 0))
            group = socket.inet_pton(socket.AF_INET6, GROUP) + struct.pack("@I", 0)
            end.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_JOIN_GROUP, group)
            end.settimeout(PATIENCE)
            end.sendto(b"probe", (GROUP, end.getsockname()[1]))
            end.recv(16)
    except OSError as error:
        return f"no IPv6 multicast, which stands for a CAN bus, on this machine: {error}"
    return ""


@cache
def terminal_problem() -> str:
    """Why there are no pseudo-terminals."""
    try:
        for end in os.openpty():
            os.close(end)
    except OSError as error:
        return f"no pseudo-terminals (is /dev/pts mounted?): {error}"
    return ""


@cache
def mount_problem() -> str:
    """Why no small disk can be mounted."""
    if problem := program_problem("mount"):
        return problem
    with tempfile.TemporaryDirectory() as folder:
        command = ["mount", "-t", "tmpfs", "-o", "size=1m", "none", folder]
        mounted = subprocess.run(command, capture_output=True, text=True)
        if mounted.returncode:
            return f"may not mount a small disk, which takes root: {mounted.stderr.strip()}"
        subprocess.run(["umount", "-l", folder], check=True)
    return ""


@cache
def real_time_problem() -> str:
    """Why a process may not be scheduled in real time; asked in a child process, which then ends."""
    ask = "import os; os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))"
    refused = subprocess.run([sys.executable, "-c", ask], stderr=subprocess.DEVNULL).returncode
    return "no permission for real-time scheduling (ulimit -r is 0)" if refused else ""


VULKAN = Need(("mesa-vulkan-drivers",), vulkan_problem)
BROWSER = Need(("chromium",), lambda: program_problem(*BROWSERS))
COMPILER = Need(("g++",), lambda: program_problem("g++"))
SDFORMAT = Need(("libsdformat-dev", "pkg-config", "g++"), sdformat_problem)
BASH = Need(("bash",), lambda: program_problem("bash"))
MULTICAST = Need((), multicast_problem)
TERMINALS = Need((), terminal_problem)
SMALL_DISK = Need((), mount_problem)
REAL_TIME = Need((), real_time_problem)
INSTALLABLE = (VULKAN, BROWSER, SDFORMAT, BASH)
"""Those that packages bring."""

if __name__ == "__main__":
    if "--vulkan-devices" in sys.argv:
        print(vulkan_devices())
    else:
        print(*(package for need in INSTALLABLE if need.problem() for package in need.packages))
