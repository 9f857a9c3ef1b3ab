"""The one kind of error that a study reports as a line, with exit code 2."""

from pathlib import Path


class StudyError(Exception):
    """Something wrong with a study: which file, which field of it, and why."""

    def __init__(self, file: Path | str, field: str, reason: str):
        place = f"{file}: {field}" if field else str(file)
        super().__init__(" ".join(f"{place}: {reason}".split()))  # whatever it quotes, one line
