"""Stage: a sentence about work that begins, and which part of the whole that is."""


class StageText(str):
    """A sentence that a command prints, with the name of the stage that it begins.

    Example:
        >>> StageText("filter", "filter and differentiate").stage
        'filter'
    """

    __slots__ = ("stage",)

    stage: str

    def __new__(cls, stage: str, sentence: str) -> "StageText":
        self = super().__new__(cls, sentence)
        self.stage = stage
        return self
