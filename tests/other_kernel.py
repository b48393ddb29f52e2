"""Prints a kernel of OpenBLAS that this machine can run besides its own: it rounds otherwise."""

import os
import platform
import subprocess
import sys

KERNELS = {
    "x86_64": ("Haswell", "Nehalem"),
    "AMD64": ("Haswell", "Nehalem"),
    "aarch64": ("NEOVERSEN1", "ARMV8"),
    "arm64": ("NEOVERSEN1", "ARMV8"),
}
"""Machine -> kernels that practically every such processor has the instructions for."""
VARIABLE = "OPENBLAS_CORETYPE"
RUNNING = """
import numpy, scipy.linalg, threadpoolctl
kernels = (one.get("architecture") for one in threadpoolctl.threadpool_info())
print(",".join(sorted({kernel for kernel in kernels if kernel})))
"""


def running(kernel: str = "") -> str:
    """The kernels that numpy and scipy really run when one is asked for; empty for another library."""
    environment = os.environ | ({VARIABLE: kernel} if kernel else {})
    found = subprocess.run(
        [sys.executable, "-c", RUNNING], env=environment, capture_output=True, text=True, check=True
    )
    return found.stdout.strip()


def other_kernel() -> str:
    """A kernel that is not the one that runs by itself; empty if there is none."""
    usual = running()
    kernels = KERNELS.get(platform.machine(), ()) if usual else ()
    return next((kernel for kernel in kernels if running(kernel) not in ("", usual)), "")


if __name__ == "__main__":
    print(other_kernel())
