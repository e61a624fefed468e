"""Shoot at a soft armour in front of a block of gel, and print the figures of both for some communication steps.

    pip install fmpy
    cargo run --release --manifest-path partners/Cargo.toml -- gelfmu-out/systems
    python examples/soft_armour.py gelfmu-out/systems/gel-soft-armour.ssp 1e-6

Armour, gel and body step one after the other. Parameters of the armour are in `partners/soft-armour-plate.toml`, with
their sources; `NAME=VALUE` replaces one, such as `areal_density=6`. Figures are those of an illustrative armour, not of
a product.
"""

import sys

from run_system import Loop

# Locals of the gel, such as the dent, are not wired: an importer that addresses the FMU itself reads them all the same.
DENT, DEEP, DEEPER = "sensor[1].displacement[3]", "sensor[2].pressure", "sensor[3].pressure"
WINDOW = 20e-6

FIGURES = {
    "energy of the bullet, J": lambda run: run.bullet_energy,
    "work on the armour, J": lambda run: run.last("energy.projectile"),
    "dissipated in the armour, J": lambda run: run.last("energy.plastic"),
    "work on the gel, J": lambda run: -run.last("energy.gel"),
    "greatest bulge, mm": lambda run: 1e3 * max(run.heights),
    "greatest rate of the bulge, m/s": lambda run: max(run.rates),
    "mass that moves at the end, g": lambda run: 1e3 * run.last("moving_mass"),
    "greatest dent of the gel, mm": lambda run: -1e3 * min(run.dents),
    "pressure 50 mm deep, MPa": lambda run: 1e-6 * max(run.pressures[DEEP]),
    "its mean over 20 us, MPa": lambda run: 1e-6 * greatest_mean(run.pressures[DEEP], run.step),
    "pressure 100 mm deep, MPa": lambda run: 1e-6 * max(run.pressures[DEEPER]),
    "its mean over 20 us at 100 mm, MPa": lambda run: 1e-6 * greatest_mean(run.pressures[DEEPER], run.step),
    "perforated": lambda run: run.last("perforated"),
    "momentum of the bullet not accounted for": lambda run: run.momentum_residual(),
    "momentum of the bulge not accounted for": lambda run: run.bulge_residual(),
    "energy of the bullet not accounted for": lambda run: run.energy_residual(),
    "energy of the armour not accounted for": lambda run: abs(run.last("energy.imbalance")) / run.bullet_energy,
    "work of armour and of gel at the bulge, difference": lambda run: run.interface_residual(),
}


def greatest_mean(values, step):
    """Greatest mean over a window of 20 us."""
    n = max(1, round(WINDOW / step))
    sums = [0.0]
    for value in values:
        sums.append(sums[-1] + value)
    return max((sums[i + n] - sums[i]) / n for i in range(len(values) - n + 1))


class Shot:
    """One run of the system, one unit after the other."""

    def __init__(self, ssp, step, stop=None, parameters=()):
        self.loop, self.step = Loop(ssp), step
        self.heights, self.rates, self.dents, self.pressures = [], [], [], {DEEP: [], DEEPER: []}
        try:
            self.loop.start([(("armour", name), value) for name, value in parameters])
            self.mass, self.speed = self.get("body", "mass"), -self.get("body", "velocity[3]")
            self.bullet_energy = self.mass * self.speed**2 / 2
            self.run(stop or self.loop.stop_time("gel"))
            self.values = {name: self.get("armour", name) for name in self.loop.units["armour"].variables}
            self.velocity = self.get("body", "velocity[3]")
            self.impulse = self.get("body", "total_impulse[3]")
            self.external = self.get("gel", "energy.external")
        finally:
            self.loop.free()

    def run(self, stop):
        order = [[unit] for unit in self.loop.units]
        for k in range(round(stop / self.step)):
            self.loop.step(k * self.step, self.step, order)
            self.heights.append(self.get("armour", "height"))
            self.rates.append(self.get("armour", "height_rate"))
            self.dents.append(self.get("gel", DENT))
            for name, values in self.pressures.items():
                values.append(self.get("gel", name))

    def get(self, unit, name):
        return self.loop.get((unit, name))

    def last(self, name):
        """A variable of the armour at the end."""
        return self.values[name]

    def momentum_residual(self):
        """Momentum that the bullet lost, less that of armour and gel, over its first."""
        lost = self.mass * (self.velocity + self.speed)
        return abs(lost - self.last("impulse.projectile") - self.impulse) / (self.mass * self.speed)

    def bulge_residual(self):
        """Momentum of the bulge, less the impulses of bullet, gel and support on it, over the first of the bullet."""
        sources = sum(self.last(f"impulse.{source}") for source in ("projectile", "gel", "support"))
        return abs(self.last("momentum") - sources) / (self.mass * self.speed)

    def energy_residual(self):
        """Energy that the bullet lost, less its work on the armour, over its first."""
        lost = self.bullet_energy - self.mass * self.velocity**2 / 2
        return abs(lost - self.last("energy.projectile")) / self.bullet_energy

    def interface_residual(self):
        """Work at force and bulge in the account of the gel, less that in those of the armour, over the energy."""
        return abs(self.external + self.last("energy.projectile") + self.last("energy.gel")) / self.bullet_energy


def table(shots):
    """Rows of figures, one column for each run."""
    heads = [f"step {1e6 * shot.step:g} us" for shot in shots]
    lines = ["| | " + " | ".join(heads) + " |", "|---" * (len(shots) + 1) + "|"]
    for name, figure in FIGURES.items():
        values = [figure(shot) for shot in shots]
        cells = [f"{value:.4g}" if abs(value) >= 1e-2 or value == 0.0 else f"{value:.1e}" for value in values]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main(arguments):
    parameters = [argument.split("=") for argument in arguments if "=" in argument]
    ssp, *steps = [argument for argument in arguments if "=" not in argument]
    steps = [float(step) for step in steps] or [1e-6]
    print(table([Shot(ssp, step, parameters=parameters) for step in steps]))


if __name__ == "__main__":
    main(sys.argv[1:])
