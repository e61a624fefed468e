"""Run gel and body in every importer and print their total impulse and final velocity, relative to the FMU alone.

    pip install fmpy libcosimpy ecospy tbb fmu-manipulation-toolbox
    cargo run --release --example ssp -- gelfmu-out/systems
    python examples/compare_importers.py gelfmu-out/systems 1e-2

Reference is the FMU alone, in one communication step: it integrates the projectile itself, so the step makes no difference.
"""

import math
import sys
from pathlib import Path

from fmpy import simulate_fmu
from run_system import IMPORTERS

STEPS = [5e-6, 10e-6, 20e-6, 40e-6]
ORDERS = {
    "fmpy": "fmpy.ssp, Jacobi",
    "libcosim": "libcosim, Jacobi",
    "ecos": "Ecos, Jacobi",
    "container": "fmucontainer, Jacobi",
    "loop": "own loop, Jacobi",
    "sequential-container": "fmucontainer, Gauss-Seidel, gel first",
    "sequential-loop": "own loop, Gauss-Seidel, gel first",
    "reversed-loop": "own loop, Gauss-Seidel, body first",
}


def reference(folder, stop):
    """Total impulse and final velocity of the FMU alone."""
    outputs = ["contact.total_impulse[3]", "projectile.predicted_velocity[3]"]
    fmu = str(Path(folder) / "BallisticGel.fmu")
    rows = simulate_fmu(fmu, stop_time=stop, step_size=stop, output_interval=stop, output=outputs)
    return [float(rows[name][-1]) for name in outputs]


def row(folder, system, importer, stop):
    """Impulse and velocity of the body for each step; or what the importer said."""
    ssp = Path(folder) / f"{system}.ssp"
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


def main(folder, stop):
    expected = reference(folder, stop)
    print(f"Reference: impulse {expected[0]:.6f} N.s, velocity {expected[1]:.6f} m/s at {1e3 * stop:g} ms.\n")
    for system in ("gel-and-body", "gel-and-body-corrected"):
        heads = [system]
        for what in ("impulse", "velocity"):
            heads += [f"{what}, {1e6 * step:.0f} us" for step in STEPS] + ["order"]
        print("| " + " | ".join(heads) + " |\n" + "|---" * len(heads) + "|")
        for importer, label in ORDERS.items():
            print(printed(label, row(folder, system, importer, stop), expected), flush=True)
        print()


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
