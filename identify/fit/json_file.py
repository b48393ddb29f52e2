"""Read a JSON file; a file that is none raises one error with the reason."""

import json
import re
from pathlib import Path
from typing import Any

from ..errors import NotAFile

HALF = re.compile(r"\\u[dD][89a-fA-F]")
"""How half of a character is written; without its other half no file or terminal takes it."""


def read_json(path: Path) -> Any:
    """What a JSON file holds.

    Raises:
        NotAFile: It is missing, cut off, or no JSON.
    """
    try:
        text = path.read_text(encoding="utf-8")
        table = json.loads(text)
        if HALF.search(text):
            json.dumps(table, ensure_ascii=False).encode()
        return table
    except OSError as error:
        raise NotAFile(f"{path} cannot be read: {error.strerror}") from error
    except RecursionError:
        raise NotAFile(f"{path} is not valid JSON: nested too deeply") from None
    except ValueError as error:
        raise NotAFile(f"{path} is not JSON, or was cut off: {error}") from error
