"""The program that the controller runs: it follows RTDE's registers by `servoj`, and stops by itself."""

from .ur_settings import UrSettings

FOLLOW, STOP = 1, 2
"""What the second integer register asks for."""
RUNNING, ASKED, SILENT = 0, 1, 2
"""Why the program has ended, in the second register that it writes."""
JOINTS = 6

PROGRAM = """\
def exidyn():
  write_output_integer_register({ended}, {RUNNING})
  write_output_integer_register({session_register}, {session})
  last = 0
  silent = 0
  why = {RUNNING}
  while why == {RUNNING}:
    count = read_input_integer_register({count})
    if count == last:
      silent = silent + 1
    else:
      silent = 0
      last = count
    end
    if read_input_integer_register({demand}) != {FOLLOW}:
      why = {ASKED}
    elif silent > {patience}:
      why = {SILENT}
    else:
      q = [{registers}]
      servoj(q, 0, 0, {cycle:g}, {lookahead:g}, {gain:g})
    end
  end
  write_output_integer_register({ended}, why)
  stopj({deceleration:g})
end
"""


class Registers:
    """Names of the registers that the driver and its program share.

    Args:
        first: Of each kind.
    """

    def __init__(self, first: int) -> None:
        self.first = first
        self.position = [f"input_double_register_{first + joint}" for joint in range(JOINTS)]
        self.count, self.demand = f"input_int_register_{first}", f"input_int_register_{first + 1}"
        self.session, self.ended = f"output_int_register_{first}", f"output_int_register_{first + 1}"

    @property
    def inputs(self) -> list[str]:
        """Those that the driver writes."""
        return [*self.position, self.count, self.demand]


def program_text(settings: UrSettings, session: int) -> str:
    """The program, which shows this number once it runs."""
    first = settings.first_register
    return PROGRAM.format(
        RUNNING=RUNNING,
        ASKED=ASKED,
        SILENT=SILENT,
        FOLLOW=FOLLOW,
        session_register=first,
        ended=first + 1,
        session=session,
        count=first,
        demand=first + 1,
        registers=", ".join(f"read_input_float_register({first + joint})" for joint in range(JOINTS)),
        patience=round(settings.dead_man / settings.cycle),
        cycle=settings.cycle,
        lookahead=settings.lookahead,
        gain=settings.gain,
        deceleration=settings.deceleration,
    )
