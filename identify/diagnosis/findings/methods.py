"""Methods of a diagnosis: verdict, model with findings, page and file.

They call modules of higher layers, which are therefore imported only when a method is called.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ...errors import ExidynError
from ...notebook import optional

if TYPE_CHECKING:
    from ...model import Model
    from .diagnosis import Diagnosis


class DiagnosisMethods:
    """Methods of `Diagnosis`."""

    @property
    def verdict(self) -> str:
        """Missing effects and their certainty, in sentences."""
        from ..words.verdict import verdict

        return "\n".join(verdict(cast("Diagnosis", self)))

    @property
    def model(self) -> "Model":
        """The model with all findings that a model can hold.

        Raises:
            ExidynError: The diagnosis comes from a file and has no model.
        """
        from ..improved.improved import found_model

        model = found_model(cast("Diagnosis", self))
        if model is None:
            raise ExidynError("this diagnosis was read from a file, which does not contain its model")
        return model

    def to_json(self) -> dict[str, Any]:
        """Content of the file that `exidyn diagnose --json` writes, as a dictionary."""
        from ..words.diagnosis_file import as_json

        return as_json(cast("Diagnosis", self))

    def save(self, path: Path | str) -> Path:
        """Write the diagnosis as JSON and return the path."""
        import json

        text = json.dumps(self.to_json(), indent=1, allow_nan=False)
        Path(path).write_text(text, encoding="utf-8")
        return Path(path)

    def to_dataframe(self) -> Any:
        """Parameters of all findings as a pandas table with one row per parameter.

        Raises:
            MissingPackage: pandas is not installed.
        """
        diagnosis = cast("Diagnosis", self)
        rows = [
            {
                "effect": finding.effect,
                "joints": ", ".join(diagnosis.joints[joint] for joint in finding.joints),
                "parameter": name,
                "value": number.value,
                "std": number.std,
                "unit": number.unit,
                "determined": name not in finding.left_out,
                "probability": finding.probability,
                "named": finding in diagnosis.findings,
            }
            for finding in diagnosis.all_findings
            for name, number in finding.parameters.items()
        ]
        return optional("pandas", "a table").DataFrame(rows)

    def report(self, path: Path | str) -> Path:
        """Write the diagnosis as one HTML page and return the path."""
        from ...pages.diagnosis_document import report_html

        Path(path).write_text(report_html(cast("Diagnosis", self)), encoding="utf-8")
        return Path(path)
