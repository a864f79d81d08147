#!/usr/bin/python3
"""Random meshes of every topology go through skein adapt, and a checker looks for what is lost.

    campaign [--minutes N] [--seed S] [--count N] [--jobs J] [--skein PATH] [--keep DIR]
    campaign --case 'SEED:key=value:...'

Prints a JSON line per run, and for each failing case, made small, one command that repeats it. Ends with 1 if any
case failed. docs/campaign.md tells more.
"""
import argparse
import collections
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
    p.add_argument("--reduce", type=float, default=40, help="seconds to spend on making a case of each kind of fault small; 0: none")
    p.add_argument("--ignore", action="append", default=[], metavar="KIND", help="say nothing of faults of this kind")
    p.add_argument("--each", type=int, default=2, help="cases of one kind of fault to print (%(default)s)")
    return p.parse_args()


class Campaign:
    def __init__(self, args):
        self.args, self.program = args, running.Program(args.skein, args.limit, args.ignore)
        self.kinds, self.times = {}, collections.Counter()  # outcomes by kind of fault, and how many runs had it
        self.runs, self.failed, self.begin = 0, 0, time.monotonic()

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
        """Prints the line of a run, and what failed."""
        self.runs += 1
        print(json.dumps(outcome.record()), flush=True)
        self.failed += bool(outcome.faults)
        for kind in set(outcome.kinds):
            self.kinds.setdefault(kind, []).append(outcome)
            self.times[kind] += 1
        if any(self.times[kind] <= self.args.each for kind in outcome.kinds):
            print_case(outcome)

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

    def make_small(self):
        """Makes the smallest case of each kind of fault smaller still. A case that is small for one kind may be the
        smallest for others, too."""
        found = []
        for kind in sorted(self.kinds, key=lambda k: -len(self.kinds[k])):
            best = min([o for o in self.kinds[kind] + found if kind in o.kinds], key=reducing.size)
            if self.args.reduce:
                best = reducing.reduce(best, kind, self.program, self.args.reduce)
            found.append(best)
            print_case(best, kind)
            self.keep(best)
            self.kinds[kind].append(best)

    def keep(self, outcome):
        if self.args.keep:
            folder = os.path.join(self.args.keep, specs.write(outcome.spec).replace(":", "_"))
            again = running.run(outcome.spec, self.program, folder)
            print("files and command:", " ".join(again.command), flush=True)

    def summary(self):
        """How often each kind of fault was seen, and its smallest case."""
        print(f"{self.runs} runs, {self.failed} failed, {time.monotonic() - self.begin:.0f} s")
        for kind, outcomes in sorted(self.kinds.items(), key=lambda item: -self.times[item[0]]):
            print(f"{self.times[kind]:5d}  {kind}\n       scripts/campaign --case '{specs.write(min(outcomes, key=reducing.size).spec)}'")


def print_case(outcome, wanted=None):
    """Prints what is wrong with a case, one sentence for each kind of fault, and how to repeat it."""
    for kind, text in reversed(dict(reversed(outcome.faults)).items()):
        print(f"{'>' if kind == wanted else ' '} {kind}: {text}")
    print(f"repeat: scripts/campaign --case '{specs.write(outcome.spec)}'", flush=True)


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
    try:
        campaign.all()
        campaign.make_small()
    except KeyboardInterrupt:
        print("stopped")
    campaign.summary()
    return int(campaign.failed > 0)


if __name__ == "__main__":
    sys.exit(main())
