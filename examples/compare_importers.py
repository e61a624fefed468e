"""Run the systems in every importer and print their total impulse and final velocity, relative to a reference.

    pip install fmpy libcosimpy ecospy tbb fmu-manipulation-toolbox
    cargo run --release --example ssp -- gelfmu-out/systems
    python examples/compare_importers.py gelfmu-out/systems

Reference of gel and body is the FMU alone, in one communication step: it integrates the projectile itself, so the step
makes no difference. Reference of gel, armour and body is the loop that steps one unit after the other, at the shortest step.
"""

import math
import sys
from pathlib import Path

from fmpy import read_model_description, simulate_fmu
from run_system import IMPORTERS, WATCHED

STEPS = [5e-6, 10e-6, 20e-6, 40e-6]
ORDERS = {
    "fmpy": "fmpy.ssp, Jacobi",
    "libcosim": "libcosim, Jacobi",
    "ecos": "Ecos, Jacobi",
    "container": "fmucontainer, Jacobi",
    "loop": "own loop, Jacobi",
    "sequential-container": "fmucontainer, Gauss-Seidel, in order",
    "sequential-loop": "own loop, Gauss-Seidel, in order",
    "reversed-loop": "own loop, Gauss-Seidel, against the order",
}


def alone(fmu, stop):
    """Total impulse and final velocity of the gel alone."""
    names = [name for _, name in WATCHED[:2]]
    rows = simulate_fmu(str(fmu), stop_time=stop, step_size=stop, output_interval=stop, output=names)
    return [float(rows[name][-1]) for name in names]


def row(ssp, importer, stop):
    """Impulse and velocity of the body for each step; or what the importer said."""
    try:
        runs = [IMPORTERS[importer](ssp, step, stop) for step in STEPS]
    except Exception as error:  # noqa: BLE001 - whatever a foreign library raises is the result
        return str(error)
    return [(impulse, body) for impulse, _, body in runs]


def order(errors):
    """Slope of the error between the two longest steps; none at round-off."""
    if abs(errors[-2]) < 1e-9:
        return "-"
    return f"{math.log(abs(errors[-1] / errors[-2])) / math.log(STEPS[-1] / STEPS[-2]):.2f}"


def printed(label, runs, expected):
    if isinstance(runs, str):
        return f"| {label} | {runs} |" + " |" * (2 * len(STEPS) + 1)
    errors = [[run[i] / expected[i] - 1.0 for run in runs] for i in (0, 1)]
    cells = [" | ".join(f"{error:+.1e}" for error in each) + f" | {order(each)}" for each in errors]
    return f"| {label} | " + " | ".join(cells) + " |"


def table(ssp, stop, expected):
    print(f"{ssp.stem}: reference {expected[0]:.6f} N.s and {expected[1]:.6f} m/s at {1e3 * stop:g} ms.\n")
    heads = ["importer"]
    for what in ("impulse", "velocity"):
        heads += [f"{what}, {1e6 * step:.0f} us" for step in STEPS] + ["order"]
    print("| " + " | ".join(heads) + " |\n" + "|---" * len(heads) + "|")
    for importer, label in ORDERS.items():
        print(printed(label, row(ssp, importer, stop), expected), flush=True)
    print()


def main(folder):
    end = lambda fmu: float(read_model_description(str(fmu)).defaultExperiment.stopTime)  # noqa: E731
    fmu = folder / "BallisticGel.fmu"
    expected = alone(fmu, end(fmu))
    for system in ("gel-and-body", "gel-and-body-corrected"):
        table(folder / f"{system}.ssp", end(fmu), expected)
    ssp, stop = folder / "gel-armour-body.ssp", end(folder / "BallisticGelBehindArmour.fmu")
    table(ssp, stop, IMPORTERS["sequential-loop"](ssp, STEPS[0], stop)[:2])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
