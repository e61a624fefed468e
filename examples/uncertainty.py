"""Tell how deep the BB of the calibration shot may rest, and which of its spreads matters most.

    python examples/uncertainty.py 32 coarse    # needs the extra `uncertainty` of the package

The numbers are the samples (a power of two; six shots each) and the level of accuracy: 32 at `coarse` are 192 shots
of some seconds. A sweep that was ended goes on from its finished shots.

Depths are those after 8 ms, when the BB rests but for some tenths of a millimetre. Mass and speed spread as far as a
laboratory accepts them. The temperature acts by `gel.strength_scale`: the 20 % gel of `docs/materials.md` has the
factor 1.87 at 10 °C and 1.1 at 20 °C, and the 10 % gel is taken to soften as fast, which is an assumption.
"""

import math
import sys

import ballistic_gel as bg
import pandas as pd
from SALib.analyze import sobol as analysis
from SALib.sample import sobol as sampling

CALIBRATED_AT = 4.0  # °C
SOFTENING = math.log(1.87 / 1.1) / 10.0  # logarithm of the strength per °C
WINDOW = 85.0, 10.0  # mm: the depth that the FBI asks for, and how far a block may be from it

PROBLEM = {
    "names": ["mass, g", "speed, m/s", "modulus of the elastic network, Pa", "temperature, °C"],
    "bounds": [[0.3305, 0.3499], [175.2, 184.4], [math.log(80e3), 0.1], [CALIBRATED_AT, 0.5]],
    "dists": ["unif", "unif", "lognorm", "norm"],
    "num_vars": 4,
}


def keys_of(samples):
    """Keys of the scene for samples of mass, speed, modulus and temperature."""
    mass, speed, modulus, temperature = samples.T
    strength = [math.exp(SOFTENING * (CALIBRATED_AT - value)) for value in temperature]
    return pd.DataFrame(
        {
            "projectile.mass": 1e-3 * mass,
            "projectile.velocity[3]": -speed,
            "gel.shear_modulus": modulus,
            "gel.strength_scale": strength,
        }
    )


def depth_of(level, out):
    """Depth of the shot without spreads, mm."""
    shot = bg.run("fbi-bb", fidelity=level, out=out, force=True, frames=False, report=False)
    return 1e3 * shot.summary["final_depth"]


def main(count=32, level="coarse"):
    samples = sampling.sample(PROBLEM, int(count), calc_second_order=False, seed=1)
    out = f"gelfmu-out/uncertainty-{level}"
    table = bg.sweep("fbi-bb", keys_of(samples), out, fidelity=level)
    if (table["status"] != "completed").any():
        sys.exit(f"some shots failed, see status and reason in {out}/results.csv")
    # Coarse cells stop the BB too early, by the same part in all shots.
    scale = depth_of("standard", f"{out}/standard") / depth_of(level, f"{out}/nominal")
    depth = 1e3 * scale * table["final_depth"].to_numpy()

    middle, half = WINDOW
    inside = (abs(depth - middle) <= half).mean()
    print(f"depth {depth.mean():.1f} mm, standard deviation {depth.std():.1f} mm, {len(depth)} shots")
    print(f"{100 * inside:.0f} % within {middle:.0f} ± {half:.0f} mm")
    indices = analysis.analyze(PROBLEM, depth, calc_second_order=False, seed=1)
    print(f"{'part of the variance':36} {'alone':>13} {'in all':>13}   with the half width of 95 %")
    for place, name in enumerate(PROBLEM["names"]):
        parts = (f"{indices[kind][place]:6.2f} ± {indices[f'{kind}_conf'][place]:4.2f}" for kind in ("S1", "ST"))
        print(f"{name:36} {' '.join(parts)}")


if __name__ == "__main__":
    main(*sys.argv[1:])
