"""Importers that prescribe the motion land near the motion that the FMU integrates."""

import iterate
import numpy as np
import pytest
import step_control
from own_body import Gel

SPEED, ENERGY = 5.0, 0.4125


def integrated(folder, stop):
    """Velocity at the end when the FMU moves the ball: in one step, for the step makes no difference."""
    gel = Gel(folder)
    gel.start()
    gel.fmu.doStep(0.0, stop)
    velocity = gel.get("projectile.predicted_velocity")[2]
    gel.free()
    return velocity


def test_an_iteration_with_ten_steps_lands_within_a_thousandth(make, coarse):
    taken = list(iterate.steps(make(), 2e-4))
    time, _, velocity, _ = taken[-1]
    assert len(taken) == 10 and time == pytest.approx(2e-3)
    assert velocity[2] == pytest.approx(integrated(coarse, 2e-3), abs=1e-3 * SPEED)
    assert 1 < max(tried for *_, tried in taken) < 25, "every step has to be repeated, and converges"


def test_an_iterated_step_leaves_no_jump(make):
    gel = make()
    for _, position, velocity, _ in iterate.steps(gel, 2e-4):
        assert np.abs(gel.get("projectile.predicted_position") - position).max() < 1e-12
        assert np.abs(gel.get("projectile.predicted_velocity") - velocity).max() < 1e-8


def test_a_controlled_step_lands_within_a_thousandth_and_follows_the_contact(make, unpacked):
    gel, lengths, residuals = make(unpacked), [], []
    for time, step, _, velocity in step_control.steps(gel, 1e-3):
        lengths.append(step)
        residuals.append(gel.get("coupling.energy_residual", 1)[0])
    assert time == pytest.approx(1e-2, rel=1e-12) and len(lengths) < 100
    assert velocity[2] == pytest.approx(integrated(unpacked, 1e-2), abs=1e-3 * SPEED)
    assert np.mean(residuals) < 1e-3 * ENERGY
    hardest = min(lengths[2:-1])
    assert 1.5 * hardest < lengths[-4], "the ball leaves: the steps become longer again"


def test_a_tighter_tolerance_takes_more_steps_and_leaves_less_energy(make):
    counts, energies = [], []
    for tolerance in (1e-2, 1e-3, 1e-4):
        gel = make()
        residuals = [gel.get("coupling.energy_residual", 1)[0] for _ in step_control.steps(gel, tolerance)]
        counts.append(len(residuals))
        energies.append(sum(residuals))
    assert counts == sorted(set(counts)) and energies == sorted(energies, reverse=True)
    assert energies[-1] > 0.0
