"""Progress messages: a sentence about the work that begins, with the name of its stage."""


class StageText(str):
    """A sentence that a command prints when a stage begins, with the name of the stage.

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
