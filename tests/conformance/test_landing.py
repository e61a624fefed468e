"""An importer that owns the sphere lands on the state that the FMU predicts."""

import numpy as np
import pytest
from own_body import Gel, steps


@pytest.mark.parametrize("step", [1e-5, 1e-4])
@pytest.mark.parametrize("force", [(0.0, 0.0, 0.0), (0.4, -0.3, -2.0)], ids=["free", "pushed"])
def test_the_importer_lands_on_the_prediction(unpacked, step, force):
    gel = Gel(unpacked)
    travelled = fastest = 0.0
    contact = False
    for _, x, predicted_x, v, predicted_v in steps(gel, step, force):
        travelled, fastest = max(travelled, np.linalg.norm(x)), max(fastest, np.linalg.norm(v))
        assert np.linalg.norm(x - predicted_x) <= 1e-12 * travelled
        assert np.linalg.norm(v - predicted_v) <= 1e-12 * fastest
        contact |= bool(np.any(gel.get("contact.impulse") != 0.0))
    importer = gel.get("energy.importer", 1)[0]
    gel.free()
    assert contact
    assert abs(importer) <= 1e-9 * 0.4125, "the importer adds no energy: half of 33 g at 5 m/s is 0.4125 J"
