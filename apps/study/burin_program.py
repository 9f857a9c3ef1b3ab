"""The burin program as studies use it: options become flags, and burin itself checks them."""

import hashlib
import subprocess
import tomllib
from pathlib import Path

from study.errors import StudyError

Value = bool | int | float | str
Options = dict[str, Value]


def flatten(table: dict, is_leaf=lambda value: not isinstance(value, dict), prefix: str = "") -> dict:
    """{"a": {"b": 1}} -> {"a.b": 1}; TOML writes a.b = 1 and [a] b = 1 alike."""
    flat = {}
    for key, value in table.items():
        if is_leaf(value):
            flat[prefix + key] = value
        else:
            flat.update(flatten(value, is_leaf, prefix + key + "."))
    return flat


def text_of(value: Value) -> str:
    """The value as burin's command line takes it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def flags(options: Options) -> list[str]:
    """`--key=value` for each option; the = keeps values that begin with a dash apart from flags."""
    return [f"--{key}={text_of(value)}" for key, value in options.items()]


def reason_of(stderr: str) -> str:
    """burin's one line without its prefix; empty when it wrote none."""
    for line in reversed(stderr.strip().splitlines()):
        if line.startswith("burin: error: "):
            return line.removeprefix("burin: error: ")
    return ""


class Burin:
    """A burin program on disk, asked for its options."""

    def __init__(self, path: Path):
        self.path = path.resolve()
        if not self.path.is_file():
            raise StudyError(self.path, "burin", "there is no such program; build it or give --burin")
        self._defaults: dict[str, Options] = {}

    def sha256(self) -> str:
        """Of the program file: results of another build are not mixed with those of this one."""
        return hashlib.sha256(self.path.read_bytes()).hexdigest()

    def config(self, command: str, options: Options) -> Options:
        """All options of `burin command` with these set. Raises ValueError with burin's reason."""
        done = subprocess.run([str(self.path), command, "--print-config", *flags(options)],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ValueError(reason_of(done.stderr) or f"exit code {done.returncode}")
        return flatten(tomllib.loads(done.stdout))

    def defaults(self, command: str) -> Options:
        """All options of `burin command` with their defaults."""
        if command not in self._defaults:
            self._defaults[command] = self.config(command, {})
        return self._defaults[command]
