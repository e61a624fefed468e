"""Run the systems in every importer: the impulse per master and order, and errors of total impulse and final velocity.

    pip install fmpy libcosimpy ecospy tbb fmu-manipulation-toolbox
    cargo run --release --manifest-path partners/Cargo.toml -- gelfmu-out/systems
    python examples/compare_importers.py gelfmu-out/systems             # both, some minutes
    python examples/compare_importers.py gelfmu-out/systems impulses    # the impulses alone

Reference of gel and body is the FMU alone, in one communication step: it integrates the projectile itself, so the step
makes no difference. Reference of gel, armour and body is the loop that steps one unit after the other, at the shortest
step.
"""

import math
import sys
from pathlib import Path

from fmpy import read_model_description, simulate_fmu
from run_system import IMPORTERS, System

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
BODY = [("body", "total_impulse[3]"), ("body", "velocity[3]")]
# Impulses along z: of the gel on each body, and of the gel on the bulge of an armour.
IMPULSES = {
    "gel-and-body": BODY[:1],
    "gel-and-body-corrected": BODY[:1],
    "gel-armour-body": [*BODY[:1], ("armour", "impulse.gel")],
    "gel-fragments": [(f"fragment{i}", "total_impulse[3]") for i in (1, 2, 3)],
    "gel-soft-armour": [("armour", "impulse.gel")],
}


def experiment(ssp):
    """Communication step and end of the run that the gel of a system suggests, s."""
    gel = read_model_description(str(ssp.parent / Path(System(ssp).files["gel"]).name)).defaultExperiment
    return float(gel.stepSize), float(gel.stopTime)


def final_impulses(ssp, importer, watched):
    """Impulses at the end, or what the importer said."""
    try:
        return [f"{value:.9f}" for value in IMPORTERS[importer](ssp, *experiment(ssp), watched)]
    except Exception as error:  # noqa: BLE001 - whatever a foreign library raises is the result
        return [str(error)] + [""] * (len(watched) - 1)


def impulse_table(folder):
    """Print the final impulses of every system, one line for each importer and order."""
    heads = [f"{system}, {unit}.{name}" for system, watched in IMPULSES.items() for unit, name in watched]
    print("Final impulses along z, N.s, with the communication step of each gel.\n")
    print("| importer | " + " | ".join(heads) + " |\n|---" + "|---" * len(heads) + "|")
    for importer, label in ORDERS.items():
        cells = []
        for system, watched in IMPULSES.items():
            cells += final_impulses(folder / f"{system}.ssp", importer, watched)
        print(f"| {label} | " + " | ".join(cells) + " |", flush=True)
    print()


def alone(fmu, stop):
    """Total impulse and final velocity of the gel alone."""
    names = ["contact.total_impulse[3]", "projectile.predicted_velocity[3]"]
    rows = simulate_fmu(str(fmu), stop_time=stop, step_size=stop, output_interval=stop, output=names)
    return [float(rows[name][-1]) for name in names]


def row(ssp, importer, stop):
    """Impulse and velocity of the body for each step; or what the importer said."""
    try:
        return [IMPORTERS[importer](ssp, step, stop, BODY) for step in STEPS]
    except Exception as error:  # noqa: BLE001 - whatever a foreign library raises is the result
        return str(error)


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


def main(folder, only=None):
    impulse_table(folder)
    if only == "impulses":
        return
    ssp = folder / "gel-and-body.ssp"
    _, stop = experiment(ssp)
    expected = alone(folder / "BallisticGel.fmu", stop)
    for system in ("gel-and-body", "gel-and-body-corrected"):
        table(folder / f"{system}.ssp", stop, expected)
    ssp = folder / "gel-armour-body.ssp"
    _, stop = experiment(ssp)
    table(ssp, stop, IMPORTERS["sequential-loop"](ssp, STEPS[0], stop, BODY))


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
