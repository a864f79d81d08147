"""What the measurements say about other numbers of ranks.

A run is a row of phases; each ends when its slowest rank is done. The time of a phase on P ranks is

    cpu + messages * latency + bytes / bandwidth + collectives * (log2(P) * latency + 8 * P / bandwidth)

each with its largest value over the ranks; a collective is taken as a gather of 8 bytes from each rank, the dearest kind
that there is in plenty. For other P and N (tetrahedra of the result) the means over the ranks are fitted to the
measured runs with more than one rank, as a sum of terms that are not negative,

    cpu of the rounds    N/P (volume of a part), (N/P)^(2/3) (its interface)
    cpu of the rest      the same, and P (what grows with the ranks)
    bytes                the same three
    memory               N/P, (N/P)^(2/3), 1 (a process that does nothing); what grows with the ranks of one machine
                         is shared memory of MPI's
    messages             1 (neighbours), P (directories that every rank talks to)
    collectives          1, P

and multiplied by the imbalance, largest over mean, of the measured runs with the most ranks.
Phases that do alike are added up first: later rounds with each other, everything but the rounds as "other".
"""
import itertools
import math

ZERO = lambda n, p: 0.0  # the place of the term in P where there is none
VOLUME = [lambda n, p: n / p, lambda n, p: (n / p) ** (2 / 3), lambda n, p: float(p)]
KERNEL = VOLUME[:2] + [ZERO]
COUNT = [lambda n, p: 1.0, lambda n, p: float(p)]
MEMORY = [lambda n, p: 1.0] + VOLUME[:2]
QUANTITIES = {"cpu": VOLUME, "bytes": VOLUME, "messages": COUNT, "collectives": COUNT}
GROUPS = ("first round", "later rounds", "partition", "other")


def group_of(phase):
    if not phase.startswith("round"):
        return "other"
    if phase.endswith("partition"):
        return "partition"
    return "first round" if phase.startswith("round 1:") else "later rounds"


def terms_of(group, quantity):
    kernel = group in ("first round", "later rounds") and quantity == "cpu"
    return KERNEL if kernel else QUANTITIES[quantity]


def grouped(run, mean=False):
    """{group: {cpu, bytes, messages, collectives}}: sums over phases of the largest values over ranks, or the means."""
    groups = {g: dict.fromkeys(QUANTITIES, 0.0) for g in GROUPS}
    for phase in run["phases"]:
        g = groups[group_of(phase["name"])]
        g["cpu"] += phase["cpu"]["mean" if mean else "max"]
        g["bytes"] += phase["bytes_sent"] / run["ranks"] if mean else phase["bytes_sent_max"]
        g["messages"] += phase["messages_sent"] / run["ranks"] if mean else phase["messages_sent_max"]
        g["collectives"] += phase["collectives"]
    return groups


def seconds(costs, ranks, latency, bandwidth):
    """Predicted time of one group of phases."""
    collective = math.log2(max(ranks, 1)) * latency + 8 * ranks / bandwidth
    return costs["cpu"] + costs["messages"] * latency + costs["bytes"] / bandwidth + costs["collectives"] * collective


def solve(a, b):
    """Gaussian elimination with pivoting; None if singular."""
    n = len(b)
    rows = [list(r) + [v] for r, v in zip(a, b)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda r: abs(rows[r][i]))
        if abs(rows[pivot][i]) < 1e-12:
            return None
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for r in range(i + 1, n):
            f = rows[r][i] / rows[i][i]
            rows[r] = [x - f * y for x, y in zip(rows[r], rows[i])]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (rows[i][n] - sum(rows[i][k] * x[k] for k in range(i + 1, n))) / rows[i][i]
    return x


def fit(points, terms):
    """Factors >= 0 of the terms with the least relative error at points [(n, p, value)]; all subsets are tried."""
    best, best_error = [0.0] * len(terms), float("inf")
    top = max(v for _, _, v in points)
    if top <= 0:
        return best
    weight = [top / max(v, 1e-3 * top) for _, _, v in points]
    scale = [max(t(n, p) for n, p, _ in points) or 1.0 for t in terms]
    for size in range(1, len(terms) + 1):
        for chosen in itertools.combinations(range(len(terms)), size):
            rows = [[w * terms[k](n, p) / scale[k] for k in chosen] for w, (n, p, _) in zip(weight, points)]
            wanted = [w * v / top for w, (_, _, v) in zip(weight, points)]
            normal = [[sum(r[i] * r[j] for r in rows) for j in range(size)] for i in range(size)]
            x = solve(normal, [sum(r[i] * v for r, v in zip(rows, wanted)) for i in range(size)])
            if x is None or min(x) < 0:
                continue
            error = sum((sum(a * b for a, b in zip(r, x)) - v) ** 2 for r, v in zip(rows, wanted))
            if error < best_error * (1 - 1e-9):
                best, best_error = [0.0] * len(terms), error
                for k, v in zip(chosen, x):
                    best[k] = v * top / scale[k]
    return best


def mean(values):
    return sum(values) / len(values)


def ratio(largest, average):
    return largest / average if average > 0 else 1.0


def value(factors, terms, n, p):
    return sum(f * t(n, p) for f, t in zip(factors, terms))


class Model:
    """Fitted to runs; needs three at least with more than one rank."""

    def __init__(self, runs):
        self.runs = [r for r in runs if r["ranks"] > 1]
        if len(self.runs) < 3:
            raise ValueError("the model needs three runs with more than one rank")
        self.most_ranks = max(r["ranks"] for r in self.runs)
        data = [(r["elements_out"], r["ranks"], grouped(r, mean=True)) for r in self.runs]
        widest = [r for r in self.runs if r["ranks"] == self.most_ranks]
        self.factors, self.imbalance = {}, {}
        for g, q in itertools.product(GROUPS, QUANTITIES):
            self.imbalance[g, q] = max(ratio(grouped(r)[g][q], grouped(r, mean=True)[g][q]) for r in widest)
            factors = fit([(n, p, d[g][q]) for n, p, d in data], terms_of(g, q))
            self.factors[g, q] = [self.imbalance[g, q] * f for f in factors]
        uneven = max(ratio(max(r["peak_bytes"]), mean(r["peak_bytes"])) for r in widest)
        self.memory = [uneven * f for f in
                       fit([(r["elements_out"], r["ranks"], mean(r["peak_bytes"])) for r in self.runs], MEMORY)]

    def costs(self, group, n, p):
        return {q: value(self.factors[group, q], terms_of(group, q), n, p) for q in QUANTITIES}

    def predict(self, n, p, latency, bandwidth):
        """{group: seconds, "all": seconds, "network": of these, not CPU, "growing": what would be less on 2 ranks}."""
        result = dict.fromkeys(("network", "growing"), 0.0)
        for g in GROUPS:
            costs = self.costs(g, n, p)
            result[g] = seconds(costs, p, latency, bandwidth)
            result["network"] += result[g] - costs["cpu"]
            fixed = {q: costs[q] - self.factors[g, q][-1] * terms_of(g, q)[-1](n, p) for q in QUANTITIES}
            result["growing"] += result[g] - seconds(fixed, 2, latency, bandwidth)
        result["all"] = sum(result[g] for g in GROUPS)
        result["memory"] = value(self.memory, MEMORY, n, p)
        return result
