"""Which mesh of ours is cheapest at a depth: run `sphere-block` on many meshes, without the FMU, and sort them by cost.

    python benches/peers/scan.py
    python benches/peers/scan.py --size 4e-3 5e-3 --core 0.010 --growth 1.5 2 --largest 0.02

A mesh counts where its depth error is no greater than that of the peers (README.md). Of those, choose one whose
neighbours in the table count too: a mesh that hits the depth by chance has neighbours that do not.
"""

import argparse
import itertools
import json
import sys
import tempfile
from pathlib import Path

import measure
from cases import ROOT, SCENE, within_peers_error


def settings(arguments):
    """Every combination of what was asked for, as keys and values of the scene; growth 1 is a uniform mesh, once."""
    for lattice, size in itertools.product(arguments.lattice, arguments.size):
        mesh = {"mesh.lattice": lattice, "mesh.size": size}
        graded = itertools.product(arguments.core, [g for g in arguments.growth if g > 1], arguments.largest)
        if 1.0 in arguments.growth:
            yield mesh
        for core, growth, largest in graded:
            if largest > size:
                yield mesh | {"mesh.grading.core": core, "mesh.grading.growth": growth, "mesh.grading.largest": largest}


def summary(gelfmu, changes):
    """Run the scene with changed values; its summary and what it cost."""
    changed = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    with tempfile.TemporaryDirectory() as out:
        quiet = ["--direct", "--threads", "1", "--json", "--quiet", "--out", out, "--set", "output.frames=1"]
        measured = measure.run([gelfmu, "run", SCENE, *quiet, *changed])
    return json.loads(measured.output) | {"cpu_s": measured.cpu_s}


def scan(gelfmu, meshes):
    """Every mesh and its summary, the cheapest in updates first; what the command refuses is said and left out."""
    found = []
    for changes in meshes:
        try:
            found.append((changes, summary(gelfmu, changes)))
        except measure.Failed as reason:
            print(f"left out: {reason}", file=sys.stderr)
    return sorted(found, key=lambda pair: pair[1]["element_updates"])


def row(changes, found):
    """A line of the table."""
    depth = 1e3 * found["peak_depth"]
    values = ", ".join(f"{key.removeprefix('mesh.')} {value}" for key, value in changes.items())
    mark = "yes" if within_peers_error(depth) else ""
    rebound = found["final_velocity"][2]
    numbers = f"{found['elements']} | {found['element_updates']:.2e} | {depth:.3f} | {rebound:.3f}"
    return f"| {values} | {numbers} | {found['cpu_s']:.2f} | {mark} |"


def arguments():
    """What to scan, from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gelfmu", type=Path, default=ROOT / "target/release/gelfmu")
    parser.add_argument("--lattice", nargs="+", default=["centred", "kuhn"])
    parser.add_argument("--size", nargs="+", type=float, default=[2.5e-3, 3.57e-3, 5e-3, 6.25e-3, 8.33e-3], help="m")
    parser.add_argument("--core", nargs="+", type=float, default=[0.010, 0.015, 0.020], help="m")
    parser.add_argument("--growth", nargs="+", type=float, default=[1.0, 1.5, 2.0], help="1: uniform")
    parser.add_argument("--largest", nargs="+", type=float, default=[0.0125, 0.025], help="m")
    return parser.parse_args()


if __name__ == "__main__":
    given = arguments()
    found = scan(given.gelfmu, settings(given))
    print("| mesh | elements | updates | depth, mm | v at 10 ms, m/s | CPU s | counts |")
    print("|---|---|---|---|---|---|---|")
    for changes, result in found:
        print(row(changes, result))
