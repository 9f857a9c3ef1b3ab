"""`python3 apps/study COMMAND ...`, from any folder."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from study.command import main  # noqa: E402  (the line above makes the package importable)

sys.exit(main(sys.argv[1:]))
