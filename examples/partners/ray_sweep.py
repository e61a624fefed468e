"""Ray sweep over the impact velocity: each actor keeps one instance of the FMU and resets it between runs.

    pip install ray fmpy
    gelfmu pack sphere-block --out gel.fmu
    python examples/partners/ray_sweep.py gel.fmu

Every actor is a process of its own, because an instance serves one call at a time.
"""

import sys
from pathlib import Path

import ray
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.simulation import instantiate_fmu
from ray.util import ActorPool

VELOCITIES = [-1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0, -8.0]
NAMES = ["contact.total_impulse[3]", "projectile.predicted_velocity[3]"]


@ray.remote(num_cpus=1)
class Shooter:
    """Actor with one instance of the FMU in a process of its own."""

    def __init__(self, fmu):
        self.folder = extract(fmu)
        self.description = read_model_description(self.folder)
        self.instance = instantiate_fmu(self.folder, self.description, fmi_type="CoSimulation")

    def shoot(self, velocity):
        """Return the impulse and the velocity along z at the end of a run with this initial velocity."""
        self.instance.reset()
        rows = simulate_fmu(
            self.folder,
            model_description=self.description,
            fmu_instance=self.instance,
            start_values={"projectile.initial_velocity[3]": velocity},
            output=NAMES,
            output_interval=1e-4,
            terminate=False,
        )
        return [float(rows[name][-1]) for name in NAMES]


if __name__ == "__main__":
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    pool = ActorPool([Shooter.remote(str(Path(sys.argv[1]).resolve())) for _ in range(2)])
    results = pool.map(lambda actor, velocity: actor.shoot.remote(velocity), VELOCITIES)
    for velocity, (impulse, final) in zip(VELOCITIES, results, strict=True):
        print(f"from {velocity:g} m/s: impulse {impulse!r} N.s, velocity {final!r} m/s")
    ray.shutdown()
