#!/usr/bin/python3
"""Random meshes of every topology go through skein adapt, and a checker looks for what is lost.

    campaign [--minutes N] [--seed S] [--count N] [--jobs J] [--skein PATH] [--keep DIR]
    campaign --case 'SEED:key=value:...'

Prints a JSON line per run, and for each failing case, made small, one command that repeats it. Ends with 1 if any
case failed. docs/campaign.md tells more.
"""
import argparse
import concurrent.futures
import json
import os
import sys
import time

import reducing
import running
import spec as specs

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def arguments():
    p = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    p.add_argument("--minutes", type=float, help="start no new case after this time")
    p.add_argument("--seed", type=int, default=1, help="seed of the first case; the next has the next (%(default)s)")
    p.add_argument("--count", type=int, help="number of cases (50 without --minutes)")
    p.add_argument("--jobs", type=int, default=1, help="cases at a time (%(default)s)")
    p.add_argument("--skein", default=os.environ.get("SKEIN", os.path.join(ROOT, "build/release/bin/skein")))
    p.add_argument("--keep", metavar="DIR", help="leave the files of failing cases in folders of DIR")
    p.add_argument("--case", help="run this one case only")
    p.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change all cases, as ranks=1")
    p.add_argument("--limit", type=float, default=running.TIME_LIMIT, help="seconds after which a run hangs (%(default)s)")
    p.add_argument("--reduce", type=float, default=40, help="seconds to spend on making a failing case small; 0: none")
    p.add_argument("--ignore", action="append", default=[], metavar="KIND", help="say nothing of faults of this kind")
    p.add_argument("--each", type=int, default=2, help="cases of one kind of fault to make small (%(default)s)")
    return p.parse_args()


class Campaign:
    def __init__(self, args):
        self.args, self.program = args, running.Program(args.skein, args.limit, args.ignore)
        self.kinds, self.runs, self.failed, self.begin = {}, 0, 0, time.monotonic()

    def seeds(self):
        count = self.args.count or (None if self.args.minutes else 50)
        seed = self.args.seed
        while (count is None or seed < self.args.seed + count) and not self.late():
            yield seed
            seed += 1

    def late(self):
        return self.args.minutes is not None and time.monotonic() > self.begin + 60 * self.args.minutes

    def text(self, seed):
        return ":".join([str(seed), *self.args.set])

    def tell(self, outcome):
        """Prints the line of a run; makes it small if it failed."""
        self.runs += 1
        print(json.dumps(outcome.record()), flush=True)
        if not outcome.faults:
            return
        self.failed += 1
        for kind in dict.fromkeys(outcome.kinds):
            known = self.kinds.setdefault(kind, [])
            small = outcome
            if len(known) < self.args.each:
                if self.args.reduce:
                    small = reducing.reduce(outcome, kind, self.program, self.args.reduce)
                self.print_case(kind, small)
            known.append(small)

    def print_case(self, kind, outcome):
        print(f"FAILED {kind}: {dict(reversed(outcome.faults))[kind]}",
              *(other for other in dict.fromkeys(outcome.kinds) if other != kind), sep="\n  also ")
        print(f"repeat: scripts/campaign --case '{specs.write(outcome.spec)}'", flush=True)
        if self.args.keep:
            folder = os.path.join(self.args.keep, specs.write(outcome.spec).replace(":", "_"))
            again = running.run(outcome.spec, self.program, folder)
            print("files and command:", " ".join(again.command), flush=True)

    def all(self):
        """Runs cases, `jobs` at a time, in the order of their seeds."""
        with concurrent.futures.ThreadPoolExecutor(self.args.jobs) as pool:
            waiting = []
            for seed in self.seeds():
                waiting.append(pool.submit(running.run, specs.parse(self.text(seed)), self.program))
                if len(waiting) >= self.args.jobs:
                    self.tell(waiting.pop(0).result())
            for future in waiting:
                self.tell(future.result())

    def summary(self):
        print(f"{self.runs} runs, {self.failed} failed, {time.monotonic() - self.begin:.0f} s")
        for kind, outcomes in sorted(self.kinds.items(), key=lambda item: -len(item[1])):
            smallest = min(outcomes, key=lambda o: (o.before.get("tetrahedra", 0), o.spec["ranks"], o.spec["threads"]))
            print(f"{len(outcomes):5d}  {kind}\n       scripts/campaign --case '{specs.write(smallest.spec)}'")


def one(campaign, args):
    """Runs the case of --case and tells all that is wrong with it."""
    outcome = running.run(specs.parse(args.case), campaign.program, args.keep)
    print(json.dumps(outcome.record()))
    print(" ".join(outcome.command))
    for kind, text in outcome.faults:
        print(f"{kind}: {text}")
    return bool(outcome.faults)


def main():
    args = arguments()
    if not os.access(args.skein, os.X_OK):
        print(f"no program {args.skein}: build it, or name it with --skein", file=sys.stderr)
        return 2
    campaign = Campaign(args)
    if args.case:
        return int(one(campaign, args))
    campaign.all()
    campaign.summary()
    return int(campaign.failed > 0)


if __name__ == "__main__":
    sys.exit(main())
