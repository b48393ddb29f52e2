"""What the exit code of `exidyn` means, the same for every command."""

DONE = 0
STOPPED = 1
"""A run ended before its time, or a person did not confirm it."""
REFUSED = 2
"""Something given was wrong or missing, as argparse has it."""
LOST = 3
"""A recording was made whole, and lacks what is lost for good; or some of many cannot be used."""
WRONG = 4
"""A joint was moved, and did not do what it should."""
UNSAFE = 5
"""After a run the arm still moves, or nobody knows whether it does."""
INTERRUPTED = 130
"""After Ctrl-C, as shells have it: 128 + SIGINT."""
READER_LEFT = 141
"""The reader of the output has left, as shells have it of all commands: 128 + SIGPIPE."""

MEANINGS = {
    DONE: "done",
    STOPPED: "a run of the arm was stopped before its end, or not confirmed (record, jog, study)",
    REFUSED: "not done: something given was wrong or missing, which one line on standard error names",
    LOST: "done, and part of the recording is lost for good (recover), or some cannot be used (fleet)",
    WRONG: "done, and the joint does not do what it should (jog)",
    UNSAFE: "after a run the arm still moves, or may: press the emergency stop (record, jog, study)",
    INTERRUPTED: "interrupted by Ctrl-C",
    READER_LEFT: "the reader of the output has left, as head does",
}
"""Code -> in words, for help and docs."""
