"""Simulate the FMU with fmpy: the projectile is integrated inside the FMU.

    pip install fmpy
    gelfmu pack
    python examples/simulate.py BallisticGel.fmu
"""

import sys

from fmpy import simulate_fmu

OUTPUTS = ["projectile.depth", "projectile.predicted_velocity[3]", "contact.force[3]"]


def simulate(fmu, step, outputs=OUTPUTS, **options):
    """Run to the end of the packed scene in communication steps of `step` seconds."""
    return simulate_fmu(fmu, step_size=step, output_interval=step, output=outputs, **options)


if __name__ == "__main__":
    result = simulate(sys.argv[1], 1e-4)
    deepest = result[result["projectile.depth"].argmax()]
    print(f"deepest: {1e3 * deepest['projectile.depth']:.3f} mm at {1e3 * deepest['time']:.2f} ms")
    print(f"velocity at the end: {result['projectile.predicted_velocity[3]'][-1]:.4f} m/s")
