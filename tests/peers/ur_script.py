"""URScript as far as programs that follow registers go: translated to a generator, a cycle a step.

What takes time in URScript (`servoj`, `stopj`, `sync`) yields until it is over; all else takes none.
"""

import re

TAKES_TIME = re.compile(r"^(servoj|stopj|sync)\(")
BLOCK = re.compile(r"^(def|while|if|elif|else)\b.*:$")
KNOWN = re.compile(r"[\w\s.,=+\-*/<>!()\[\]:\"]+")


class ScriptError(Exception):
    """What a controller would refuse to compile."""


def translated(text):
    """Python's text of a program; each line is looked at, so that nothing else than a program is run."""
    lines, depth = [], 0
    for number, raw in enumerate(text.splitlines(), 1):
        line = raw.split("#")[0].strip()
        if not line:
            continue
        if not KNOWN.fullmatch(line) or "__" in line:
            raise ScriptError(f"line {number}: {line}")
        if line == "end":
            depth -= 1
            continue
        again = line.startswith(("elif", "else"))
        line = line.removeprefix("local ").removeprefix("global ")
        if not depth and not line.startswith("def "):
            raise ScriptError(f"line {number}: {line}")
        if line.endswith(":") != bool(BLOCK.match(line)) or depth - again < 0:
            raise ScriptError(f"line {number}: {line}")
        if TAKES_TIME.match(line):
            line = f"yield from {line}"
        lines.append(" " * (depth - again) + line)
        depth += line.endswith(":") and not again
    if depth:
        raise ScriptError("an end is missing")
    return "\n".join(lines)


def program(text, functions):
    """A generator that runs a program with these functions, a step a cycle; it must be one `def`."""
    name = re.match(r"\s*def (\w+)\(\):", text)
    if not name:
        raise ScriptError("not a program")
    scope = {"__builtins__": {}, **functions}
    try:
        exec(translated(text), scope)  # of our own driver, on this computer
    except SyntaxError as error:
        raise ScriptError(str(error)) from error
    return scope[name[1]]()
