"""fmpy runs the packed scene."""

import pytest
from simulate import simulate

# Numbers of the scene: six codes with a soft penalty give 14.05 mm at 4.62 ms and 3.863 m/s at 10 ms.
DEPTH, REBOUND = 14.05e-3, 3.863


@pytest.fixture(scope="module")
def results(fmu):
    return {step: simulate(fmu, step) for step in (1e-5, 1e-4)}


@pytest.mark.parametrize("step", [1e-5, 1e-4])
def test_the_ball_goes_in_and_comes_back(results, step):
    result = results[step]
    assert result["time"][-1] == pytest.approx(0.01, rel=1e-9)
    assert len(result) == round(0.01 / step) + 1
    assert result["projectile.depth"].max() == pytest.approx(DEPTH, rel=0.1)
    assert result["projectile.predicted_velocity[3]"][-1] == pytest.approx(REBOUND, rel=0.1)


def test_a_run_that_the_mesh_cannot_follow_ends_by_itself(fmu):
    faster = {"projectile.initial_velocity[3]": -2000.0}
    result = simulate(fmu, 1e-5, start_values=faster)
    assert 0.0 < result["time"][-1] < 0.005


def test_the_communication_step_changes_no_bit(results):
    for name in ("projectile.depth", "projectile.predicted_velocity[3]"):
        fine, wide = (results[step][name][-1] for step in (1e-5, 1e-4))
        assert fine.hex() == wide.hex()
