#!/usr/bin/env python3
"""The folders are the architecture, and the pages that describe them are true.

 - Includes go the way that the table of rooms in docs/extending.md allows, and say the room.
 - Every room has a README.md that names what it may use as that table does.
 - Every path that README.md, docs/ and comments name exists, and every function and type that
   docs/extending.md names beside a file is in that file.
 - Source files have at most 400 lines, but for those listed here with a reason.

rooms_test.py [REPOSITORY]: a line FILE:LINE: REASON for each fault, exit code 1 when there is one.
"""
import glob
import os
import re
import subprocess
import sys

MAX_LINES = 400
LONG_FILES = {  # path: reason
    "tests/cli_test.cc": "one program's command line, with its fixtures",
    "tests/formats_test.cc": "a case for each format over the same scene",
    "tests/subdivide_test.cc": "one function",
    "tests/synthetic_test.cc": "cases share scenes that take seconds to make",
}

TOP = "core|apps|costs|selection|tests|bench|python|docs|cmake|third_party_notes"
INCLUDE = re.compile(r'\s*#\s*include\s+"([^"]+)"')
ROW = re.compile(r"\| `([\w/]+)` \|.*\|([^|]*)\|$")
PATH = re.compile(r"(?<![\w/.$-])((?:%s)/[\w./*-]*[\w*])" % TOP)
LINK = re.compile(r"\]\(([^)#\s]*)(#[^)\s]*)?\)")


def rooms(page):
    """{room: rooms it may use directly} of the table under "## Rooms"."""
    section = page.split("\n## Rooms\n", 1)[1].split("\n## ", 1)[0]
    table = {}
    for line in section.split("\n"):
        match = ROW.match(line)
        if match:
            table[match.group(1)] = re.findall(r"`([\w/]+)`", match.group(2))
    return table


def room_of(path, table):
    """The innermost room that the file is in, or None."""
    folder = os.path.dirname(path)
    while folder and folder not in table:
        folder = os.path.dirname(folder)
    return folder or None


def reachable(room, table):
    found = {room}
    for used in table[room]:
        found |= reachable(used, table)
    return found


def include_faults(files, table):
    for path in files:
        room = room_of(path, table)
        if not path.endswith((".h", ".cc", ".inc")) or room is None:
            continue
        may_use = reachable(room, table)
        for number, line in enumerate(open(path, encoding="utf-8"), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            target = match.group(1)
            if not os.path.isfile(target):
                yield f"{path}:{number}: \"{target}\" is no file of the repository"
            elif room_of(target, table) not in may_use:
                yield (f"{path}:{number}: {room} may not use "
                       f"{room_of(target, table) or os.path.dirname(target)} (\"{target}\")")


def table_faults(files, table):
    page = "docs/extending.md"
    for room, uses in table.items():
        for name in [room] + uses:
            if name not in table or not os.path.isdir(name):
                yield f"{page}:1: the table names {name}, which is no room"
        readme = f"{room}/README.md"
        if not os.path.isfile(readme):
            yield f"{readme}:1: is missing"
            continue
        lines = open(readme, encoding="utf-8").readlines()
        for name in re.findall(r"`([a-z_/]+\.(?:h|inc))`", "".join(lines)):
            if not os.path.isfile(f"{room}/{name}"):
                yield f"{readme}:1: {name} does not exist"
        lines = [line for line in lines if line.startswith("May use: ")]
        said = re.findall(r"`([\w/]+)`", lines[0]) if len(lines) == 1 else None
        if said != uses:
            yield f"{readme}:1: must have one line \"May use:\" with {uses}, as {page} says"
    for path in files:
        in_source = re.match(r"(core|costs|selection|apps)/.*\.(h|cc|inc)$", path)
        if in_source and room_of(path, table) is None and path != "apps/burin.cc":
            yield f"{path}:1: is in no room of {page}"


def path_faults(files):
    known = set(files)
    folders = set()
    for path in files:
        while "/" in path:
            path = path.rsplit("/", 1)[0]
            folders.add(path)
    exists = lambda p: p in known or p in folders or any(q in known for q in glob.glob(p))
    for path in files:
        text_file = path.endswith((".md", ".h", ".cc", ".inc", ".py", ".sh", ".toml", ".txt", ".in"))
        if not text_file or path.startswith("tests/fuzz/corpus") or path == "tests/rooms_test.py":
            continue
        for number, line in enumerate(open(path, encoding="utf-8"), 1):
            if INCLUDE.match(line):
                continue
            for match in PATH.finditer(line):
                if "NAME" not in match.group(1) and not exists(match.group(1)):
                    yield f"{path}:{number}: {match.group(1)} does not exist"
            if path.endswith(".md"):
                yield from link_faults(path, number, line, exists)


def link_faults(path, number, line, exists):
    for match in LINK.finditer(line):
        target, anchor = match.group(1), match.group(2)
        if target.startswith("http"):
            continue
        page = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
        if not exists(page):
            yield f"{path}:{number}: the link {target} leads nowhere"
        elif anchor:
            heads = re.findall(r"^#+ (.*)", open(page, encoding="utf-8").read(), re.M)
            slugs = [re.sub(r"[^\w\- ]", "", h.strip().lower()).replace(" ", "-") for h in heads]
            if anchor[1:] not in slugs:
                yield f"{path}:{number}: {page} has no heading for {anchor}"


def name_faults():
    """`file`: `Name`, `Name` in docs/extending.md: each Name is a word of that file."""
    page = "docs/extending.md"
    for number, line in enumerate(open(page, encoding="utf-8"), 1):
        pairs = re.findall(r"`([\w/]+\.(?:cc|h|inc|py))`(?:: (?:the table )?((?:`[\w:]+`(?:, | = )?)+))?", line)
        for path, names in pairs:
            if not os.path.isfile(path):
                continue  # path_faults says so
            words = set(re.findall(r"\w+", open(path, encoding="utf-8").read()))
            for name in re.findall(r"[\w:]+", names):
                if not set(name.split("::")) <= words:
                    yield f"{page}:{number}: {path} has no {name}"
    # Every other word in code style that looks like a type or a function of burin is somewhere.
    text = open(page, encoding="utf-8").read()
    prose = re.sub(r"```.*?```", "", text, flags=re.S)
    sources = [p for p in glob.glob("**/*", recursive=True)
               if re.match(r"(core|costs|selection|apps|tests|python)/.*\.(h|cc|inc)$", p)]
    everything = set()
    for path in sources:
        everything |= set(re.findall(r"\w+", open(path, encoding="utf-8").read()))
    for number, line in enumerate(prose.split("\n"), 1):
        for code in re.findall(r"`([A-Z]\w+(?:::\w+)*)(?:\(\))?`", line):
            missing = [part for part in code.split("::") if part not in everything]
            if missing:
                yield f"{page}: `{code}` is nowhere in the sources"


def length_faults(files):
    for path in files:
        if re.search(r"\.(h|cc|inc|py)$", path):
            count = sum(1 for _ in open(path, encoding="utf-8"))
            if count > MAX_LINES and path not in LONG_FILES:
                yield f"{path}:{count}: more than {MAX_LINES} lines"


def main():
    os.chdir(sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(__file__), ".."))
    git = ["git", "-c", f"safe.directory={os.getcwd()}", "ls-files", "--cached", "--others",
           "--exclude-standard"]
    files = sorted({f for f in subprocess.check_output(git, text=True).split("\n") if os.path.isfile(f)})
    table = rooms(open("docs/extending.md", encoding="utf-8").read())
    faults = [*include_faults(files, table), *table_faults(files, table), *path_faults(files),
              *name_faults(), *length_faults(files)]
    for fault in faults:
        print(fault)
    includes = sum(f.endswith((".h", ".cc", ".inc")) for f in files)
    print(f"{len(table)} rooms, {includes} source files, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
