"""The soft armour of gel-soft-armour.ssp: its accounts, and the same motion in every importer."""

import pytest
import run_system
from conftest import ON_LINUX
from soft_armour import FIGURES, Shot, table

FOREIGN = pytest.mark.skipif(not ON_LINUX, reason="there is no wheel for this platform")
WATCHED = [("armour", "height"), ("armour", "impulse.gel"), ("body", "velocity[3]")]


@pytest.fixture(scope="module")
def shot(systems):
    """The first 0.2 ms, in which the armour stops the bullet."""
    return Shot(systems.folder / "gel-soft-armour.ssp", 1e-6, 2e-4)


def test_the_armour_stops_a_handgun_bullet_and_dents_the_gel(shot):
    assert shot.mass == 8e-3 and shot.speed == 350.0
    assert shot.last("perforated") == 0.0 and 5e-3 < shot.last("penetration") < 13.5e-3
    assert 100.0 < max(shot.rates) < 250.0 and 0.012 < max(shot.heights) < 0.03
    assert -0.03 < min(shot.dents) < -0.012, "the gel follows the bulge"
    assert max(shot.pressures["sensor[2].pressure"]) > 1e6


def test_momentum_and_energy_of_bullet_armour_and_gel_are_accounted_for(shot):
    assert shot.momentum_residual() < 1e-12 and shot.bulge_residual() < 1e-10
    assert shot.energy_residual() < 1e-9 and abs(shot.last("energy.imbalance")) < 1e-3 * shot.bullet_energy
    assert shot.interface_residual() < 1e-2, "of first order: the armour feels the gel of the step before"
    stored = sum(shot.last(f"energy.{kind}") for kind in ("kinetic", "elastic", "plastic"))
    assert stored < shot.last("energy.projectile") + shot.last("energy.gel") + 1.0


def test_the_table_has_a_row_for_every_figure(shot):
    lines = table([shot]).splitlines()
    assert len(lines) == 2 + len(FIGURES) and lines[0] == "| | step 1 us |"


@pytest.mark.parametrize(
    "importer",
    ["fmpy", pytest.param("libcosim", marks=FOREIGN), pytest.param("ecos", marks=FOREIGN), "container"],
)
def test_importers_that_step_all_at_once_agree(systems, importer):
    ssp, step, stop = systems.folder / "gel-soft-armour.ssp", 1e-6, 5e-5
    expected = run_system.with_loop(ssp, step, stop, WATCHED)
    assert run_system.IMPORTERS[importer](ssp, step, stop, WATCHED) == pytest.approx(expected, rel=1e-6)
    assert expected[0] > 3e-3
