"""A bus is for one exidyn process of a computer."""

import subprocess
import sys

import pytest

from exidyn.drivers.can.claim import Claim
from exidyn.drivers.errors import NotReady

from ...peers.can_arm import free_port

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="only Linux has names that end with a process"
)

HOLD = """
import sys
from exidyn.drivers.can.claim import Claim
claim = Claim(sys.argv[1])
print("has it", flush=True)
input()
"""


def test_a_second_process_is_refused_and_told_which_has_it():
    bus = f"CAN bus test {free_port()}"
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, bus], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as holder:
        assert holder.stdout.readline() == "has it\n"
        with pytest.raises(NotReady, match=rf"in use by another exidyn \(process {holder.pid}\)"):
            Claim(bus)
        holder.kill()  # a claim ends with its process, however it ends
        holder.wait()
    Claim(bus).release()


def test_one_process_may_have_several_and_let_go_twice():
    bus = f"CAN bus test {free_port()}"
    first, second = Claim(bus), Claim(bus)
    for claim in (second, first, first):
        claim.release()
    Claim(bus).release()
