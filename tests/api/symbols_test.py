"""A shared library shows the functions of the public headers, skein::Error, and nothing else.

    symbols_test.py LIBRARY SKEIN_H
"""
import re
import subprocess
import sys

CXX = [r"skein::version\(\)", r"skein::adapt\(.*\)", r"(typeinfo|typeinfo name|vtable) for skein::Error",
       r"skein::Error::~?Error\(.*\)"]


def main(library, header):
    out = subprocess.run(["nm", "--dynamic", "--defined-only", "--demangle", library], capture_output=True, text=True,
                         check=True).stdout
    shown = {line.split(maxsplit=2)[2] for line in out.splitlines()}
    with open(header, encoding="ascii") as f:
        code = re.sub(r"//.*", "", f.read())
    wanted = set(re.findall(r"SKEIN_EXPORT[^;]*?\b(skein_\w+)\s*\(", code))
    unknown = [s for s in shown - wanted if not any(re.fullmatch(p, s) for p in CXX)]
    missing = sorted(wanted - shown)
    adapts = [s for s in shown if s.startswith("skein::adapt(")]
    for what, names in (("shown, but not of the API", unknown), ("missing", missing)):
        for name in names:
            print(f"{what}: {name}")
    if len(adapts) != 2:
        print(f"two functions skein::adapt are wanted, not {len(adapts)}")
    print(f"{len(shown)} symbols, {len(wanted)} of them for C")
    return 1 if unknown or missing or len(adapts) != 2 or len(wanted) < 30 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
