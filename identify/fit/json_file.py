"""Read a JSON file; a file that is none raises one error with the reason."""

import json
from pathlib import Path
from typing import Any

from ..errors import NotAFile


def read_json(path: Path) -> Any:
    """What a JSON file holds.

    Raises:
        NotAFile: It is missing, cut off, or no JSON.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise NotAFile(f"{path} cannot be read: {error.strerror}") from error
    except RecursionError:
        raise NotAFile(f"{path} is not valid JSON: nested too deeply") from None
    except ValueError as error:
        raise NotAFile(f"{path} is not JSON, or was cut off: {error}") from error
