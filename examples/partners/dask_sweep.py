"""Dask sweep over the impact velocity: each worker keeps one instance of the FMU and resets it between runs.

    pip install "dask[distributed]" fmpy
    gelfmu pack sphere-block --out gel.fmu
    python examples/partners/dask_sweep.py gel.fmu

Every worker is a process with one thread, because an instance serves one call at a time.
"""

import sys

from distributed import Client, LocalCluster, get_worker
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.simulation import instantiate_fmu

VELOCITIES = [-1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0, -8.0]
NAMES = ["contact.total_impulse[3]", "projectile.predicted_velocity[3]"]


def instance_of(worker, fmu):
    """Return folder, description and instance of the FMU; the worker keeps them from the first run on."""
    if not hasattr(worker, "gel"):
        folder = extract(fmu)
        description = read_model_description(folder)
        worker.gel = folder, description, instantiate_fmu(folder, description, fmi_type="CoSimulation")
    return worker.gel


def shoot(fmu, velocity):
    """Return the impulse and the velocity along z at the end of a run with this initial velocity."""
    folder, description, instance = instance_of(get_worker(), fmu)
    instance.reset()
    rows = simulate_fmu(
        folder,
        model_description=description,
        fmu_instance=instance,
        start_values={"projectile.initial_velocity[3]": velocity},
        output=NAMES,
        output_interval=1e-4,
        terminate=False,
    )
    return [float(rows[name][-1]) for name in NAMES]


if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1) as cluster, Client(cluster) as client:
        runs = client.map(shoot, [sys.argv[1]] * len(VELOCITIES), VELOCITIES, pure=False)
        for velocity, (impulse, final) in zip(VELOCITIES, client.gather(runs), strict=True):
            print(f"from {velocity:g} m/s: impulse {impulse!r} N.s, velocity {final!r} m/s")
