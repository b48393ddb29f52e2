"""A choice of a study of the two-joint arm, as a file has it."""

from exidyn.acquire.study.choice_file import FORMAT


def choice(verdict, moved=10.0):
    """As choice.json holds it."""
    offer = {
        "name": "a swept sine",
        "motion": 15.0,
        "seconds": 75.0,
        "request": "Hang the body on the flange",
    }
    return {
        "exidyn_study": FORMAT,
        "verdict": verdict,
        "believed": ["Joint 2 has a spring."],
        "findings": [],
        "entropy": 2.0 - moved / 20.0,
        "left_over_noise": {"shoulder": 1.1, "elbow": 3.0 - moved / 20.0},
        "items": [{"words": "spring or weight", "entropy": 1.0, "open": True, "decidable": verdict == "run"}],
        "offers": [offer | {"gained": 0.9}],
        "remains": ["Spring or weight. No motion settles it."] if verdict == "undecidable" else [],
        "moved": moved,
        "asked": {},
        "shapes": [],
        "chosen": {"recording": "this"} if verdict == "run" else None,
    }
