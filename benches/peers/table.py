"""The table that is printed, and the sentence under it."""

import os
import platform
from pathlib import Path
from statistics import median

import cases

HEADINGS = [
    "who", "elements", "step, µs", "depth, mm", "error, mm", "at, ms", "v at 10 ms, m/s", "CPU s, least", "median",
    "in steps", "wall s", "peak MB",
]  # fmt: skip


def machine():
    """The processor, its cores, and the Python that started the runs."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    processor = (names or [platform.machine()])[0]
    return {"processor": processor, "cores": os.cpu_count(), "python": platform.python_version()}


def least(runs, key):
    """The least of a quantity over the runs of a case."""
    return min(run[key] for run in runs)


def cells(case, runs):
    """A row: the answer is that of every run, the costs are the least, and the median of the CPU seconds."""
    answer = runs[0]
    depth = 1e3 * answer["depth"]
    yield f"{case.name} {answer['version']}"
    yield from [str(answer["elements"]), f"{1e6 * case.step:g}", f"{depth:.3f}", f"{cases.error(depth):+.2f}"]
    yield from [f"{1e3 * answer['deepest_at']:.2f}", f"{answer['rebound']:.3f}"]
    yield from [f"{least(runs, 'cpu_s'):.2f}", f"{median(run['cpu_s'] for run in runs):.2f}"]
    yield from [f"{least(runs, 'stepping_cpu_s'):.2f}", f"{least(runs, 'wall_s'):.2f}", f"{least(runs, 'peak_mb'):.0f}"]


def line(values):
    """A line of a Markdown table."""
    return f"| {' | '.join(values)} |"


def cheapest(results):
    """The result with the least CPU seconds; none of none."""
    return min(results, key=lambda result: least(result[1], "cpu_s"), default=None)


def verdict(results):
    """A sentence for each mesh of ours: its cost and depth error against the cheapest peer in either step."""
    peers = [result for result in results if not result[0].is_ours]
    rivals = [cheapest([r for r in peers if r[0].step == step]) for step in [cases.AGREED_STEP, cases.LONGEST_STEP]]
    for name in dict.fromkeys(case.name for case, _ in results if case.is_ours):
        _, runs = cheapest([r for r in results if r[0].name == name])
        cost = least(runs, "cpu_s")
        against = [comparison(rival, cost) for rival in rivals if rival]
        yield "; ".join([f"- {name}: {cost:.2f} CPU s, {depth_errors(1e3 * runs[0]['depth'])}", *against]) + "."


def comparison(rival, cost):
    """What a peer costs, and how often `cost` goes into that."""
    case, runs = rival
    its = least(runs, "cpu_s")
    return f"{case.name} in steps of {1e6 * case.step:g} µs takes {its:.2f}, {its / cost:.2f} times as much"


def depth_errors(depth):
    """A depth error, mm, beside that of the peers."""
    word = "no greater" if cases.within_peers_error(depth) else "greater"
    return f"depth error {cases.error(depth):+.2f} mm, {word} than the peers' {cases.error(cases.PEERS):+.2f} mm"


def csv(results):
    """The peers as `python -m ballistic_gel trade sphere-block --others` reads them: SI, the least CPU seconds."""
    yield "run,peak_depth,final_speed,cpu_seconds"
    for case, runs in results:
        if not case.is_ours:
            answer = runs[0]
            name = f"{case.name} in steps of {1e6 * case.step:g} µs"
            yield f"{name},{answer['depth']:.6f},{answer['rebound']:.4f},{least(runs, 'cpu_s'):.2f}"


def markdown(results):
    """Machine, table and verdict."""
    rows = [line(cells(case, runs)) for case, runs in results]
    about = ", ".join(f"{key}: {value}" for key, value in machine().items())
    return "\n".join([about, "", line(HEADINGS), line(["---"] * len(HEADINGS)), *rows, "", *verdict(results)])
