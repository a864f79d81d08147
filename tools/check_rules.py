#!/usr/bin/env python3
"""Checks the rules of the source tree that no compiler checks. Standard library only.

    check_rules.py [ROOT]

Errors (exit code 1):
  - <mpi.h> is included or an MPI_ name used outside comm/
  - a room includes one that it may not know (table ALLOWED; docs/architecture.md explains it)
  - an include that climbs ("../"), or a header without #pragma once
  - a path into somebody's home or work folder
  - a file of more than 400 lines without comments and empty lines
"""
import re
import sys
from pathlib import Path

# The rooms from the ground up, and what each may include besides itself and base. Data flows one way, and so do the
# includes: a room knows only rooms above it in this list.
SERIAL = {"mesh", "metric", "geometry", "kernel"}  # one part, no MPI
ALLOWED = {
    "skein": set(),  # include/skein, the public headers
    "base": {"skein"},
    "comm": set(),
    "mesh": set(),
    "metric": {"mesh"},
    "geometry": {"mesh", "metric"},
    "kernel": {"mesh", "metric", "geometry"},
    "partition": {"comm"},
    "dist": {"comm", "partition"} | SERIAL - {"kernel"},
    "solution": {"comm", "partition", "dist"} | SERIAL,
    "adapt": {"comm", "partition", "dist", "solution"} | SERIAL,
    "generate": {"comm", "partition", "dist", "solution", "adapt"} | SERIAL,
    "io": {"comm", "partition", "dist", "solution"} | SERIAL,
    "report": {"comm", "partition", "dist", "solution", "io"} | SERIAL,
}
ALLOWED["api"] = {"skein", "comm", "partition", "dist", "solution", "adapt", "report"} | SERIAL
ALLOWED["app"] = set(ALLOWED)
for room, rooms in ALLOWED.items():
    if room != "skein":
        rooms.add("base")

CODE_FOLDERS = ("include", "comm", "partition", "src", "tests", "bench", "examples")
MAY_USE_MPI = ("comm/", "tests/comm/", "tests/support/", "tests/api/", "examples/embed/")
# The public functions take a communicator: these headers include <mpi.h>, and src/api may name the type, to hand it on.
MAY_INCLUDE_MPI = MAY_USE_MPI + ("include/skein/",)
MAY_NAME_MPI_COMM = ("include/skein/", "src/api/")
CODE_ENDINGS = {".cpp", ".hpp", ".h", ".cc"}
TEXT_ENDINGS = CODE_ENDINGS | {".py", ".md", ".txt", ".cmake", ".json", ".toml", ".sh", ""}
SKIP = {".git", "build", "__pycache__"}
LONG = 400

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
MPI_NAME = re.compile(r"\bP?MPI_[A-Z]\w*")
FOREIGN_PATH = re.compile(r"(?<![\w.])/(?:work|home|root|Users)/\w")
NOT_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)


def room_of(relative):
    """The room that a file belongs to, or None for tests, benchmarks and examples."""
    parts = relative.parts
    if parts[0] in ("comm", "partition"):
        return parts[0]
    if parts[0] == "include":
        return "skein"
    return parts[1] if parts[0] == "src" and len(parts) > 2 else None


def blank(match):
    return re.sub(r"[^\n]", " ", match.group(0))


def check_includes(relative, lines):
    room = room_of(relative)
    for number, line in enumerate(lines, 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        quote, path = match.groups()
        if path.startswith("..") or "/../" in path:
            yield number, f'includes "{path}": write the path from the root or from src/'
        path_in_tree = path.removeprefix("src/")
        target = path_in_tree.split("/")[0]
        if quote == '"' and room in ALLOWED and target in ALLOWED and target != room and target not in ALLOWED[room]:
            yield number, f'{room} must not include {target} ("{path}")'


def check_mpi(relative, lines, code):
    path = relative.as_posix()
    if path.startswith(MAY_USE_MPI):
        return
    for number, (line, stripped) in enumerate(zip(lines, code), 1):
        match = INCLUDE.match(line)
        if match and match.group(2) == "mpi.h" and not path.startswith(MAY_INCLUDE_MPI):
            yield number, "<mpi.h> is included outside comm/"
        for name in MPI_NAME.findall(stripped):
            if name != "MPI_Comm" or not path.startswith(MAY_NAME_MPI_COMM):
                yield number, f"{name} is used outside comm/"


def check_code(relative, text):
    lines = text.split("\n")
    code = NOT_CODE.sub(blank, text).split("\n")
    yield from check_includes(relative, lines)
    yield from check_mpi(relative, lines, code)
    long = sum(1 for line in code if line.strip())
    if long > LONG:
        yield 1, f"{long} lines without comments; a file has at most {LONG}"
    if relative.suffix in (".hpp", ".h") and "#pragma once" not in text:
        yield 1, "a header needs #pragma once"


def files_of(root):
    for path in sorted(root.rglob("*")):
        relative = path.relative_to(root)
        if path.is_file() and not SKIP.intersection(relative.parts):
            yield path, relative


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent)
    errors = checked = 0
    for path, relative in files_of(root):
        is_code = relative.suffix in CODE_ENDINGS and relative.parts[0] in CODE_FOLDERS
        if not is_code and relative.suffix not in TEXT_ENDINGS:
            continue
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        findings = list(check_code(relative, text)) if is_code else []
        findings += [
            (number, f"names a path of one machine: {line.strip()[:80]}")
            for number, line in enumerate(text.split("\n"), 1)
            if FOREIGN_PATH.search(line)
        ]
        checked += 1
        errors += len(findings)
        for number, what in sorted(findings):
            print(f"{relative}:{number}: error: {what}")
    print(f"check_rules: {checked} files, {errors} errors")
    if checked == 0:
        print(f"check_rules: error: no source found under {root}")
    return 1 if errors or checked == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
