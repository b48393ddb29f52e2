"""Exit codes of `exidyn`, the same for every command."""

DONE = 0
STOPPED = 1
"""A run was stopped before its end, or a person did not confirm it."""
REFUSED = 2
"""An argument or a file was wrong or missing; argparse uses the same code."""
LOST = 3
"""A recording was recovered with permanent losses."""
WRONG = 4
"""A joint was moved and did not behave as expected."""
UNSAFE = 5
"""After a run the arm still moves, or it is unknown whether it does."""
INTERRUPTED = 130
"""Ctrl-C, by the convention of shells: 128 + SIGINT."""
READER_LEFT = 141
"""The reader of the output has closed it, by the convention of shells: 128 + SIGPIPE."""

MEANINGS = {
    DONE: "done",
    STOPPED: "a run of the arm was stopped early, or you did not type yes (record, jog)",
    REFUSED: "not done: an argument or a file is wrong or missing; one line on standard error names it",
    LOST: "done, but part of the recording is lost (info --repair)",
    WRONG: "done, but the joint does not behave as expected (jog)",
    UNSAFE: "after a run the arm still moves, or may: press the emergency stop (record, jog)",
    INTERRUPTED: "interrupted by Ctrl-C",
    READER_LEFT: "the reader of the output has closed it, as head does",
}
"""Exit code -> its meaning, for help and docs."""
