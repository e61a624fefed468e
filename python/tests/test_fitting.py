"""Fits of a gel to shots: a small block, and what is refused."""

import tomllib

import numpy as np
import pandas as pd
import pytest

import ballistic_gel as bg
from ballistic_gel.fitting import ShotModel, _conclude, _fit
from ballistic_gel.gel_parameters import PARAMETERS, gel_overrides
from ballistic_gel.samplers import import_scipy
from ballistic_gel.shot_table import read_shot_table

# A slow BB into a small block of coarse cells, with a slower wave: a run takes less than a second.
SMALL = {
    "mesh.size": 0.54e-3,
    "remesh.smallest": 0.27e-3,
    "gel.shape.cylinder.height": 0.04,
    "gel.shape.cylinder.radius": 0.03,
    "gel.bulk_modulus": 370.8e6,
    "gel.viscosity.linear": 0.1,
    "scene.end_time": 3e-3,
    "gel.shear_modulus": 0.08e6,
    "gel.branches": [{"shear_modulus": 4.8e6, "power_law": {"stress": 600.0, "exponent": 0.8}}],
    "gel.cavity": "vented",
}


def _shots(*rows):
    names = ["name", "speed", "measure", "value", "band", "window"]
    return pd.DataFrame([dict(zip(names, row, strict=False)) for row in rows])


def _small():
    return bg.Scene.built_in("fbi-bb").with_values(SMALL)


def test_a_fit_meets_its_shot_and_its_lines_give_the_computed_value(tmp_path):
    # Runs whose stress differs by thousandths end within 0.5 mm: half a band is three of their standard deviations.
    shots = _shots(("bb", 60, "depth", 0.0181, 1e-3), ("wide", 60, "cavity", 4.7e-3, 1e-3, 1e-3))
    given = {"scene": _small(), "parameters": ["stress"], "progress": False}
    fit = bg.fit_gel(shots, out=tmp_path / "fit", **given)
    assert fit.status == "fitted" and abs(fit.table["residual"]["bb"]) < 0.5, str(fit)
    assert -0.03 < fit.sensitivity["stress"]["bb"] < -1e-4, "a stronger gel is not penetrated as deep"
    law = tomllib.loads(fit.lines)["gel"]["branches"][0]["power_law"]
    assert law["stress"] == fit.values["stress"]
    again = bg.fit_gel(shots, out=tmp_path / "fit", start=fit.values, steps=0, **given)
    assert again.status == "derivatives" and again.table["computed"].equals(fit.table["computed"])


def test_leaving_out_a_shot_shows_its_influence_on_the_fit(tmp_path):
    shots = _shots(("slow", 50, "depth", 0.014, 1e-3), ("fast", 70, "depth", 0.024, 1e-3))
    fit = bg.fit_gel(shots, ["stress"], scene=_small(), steps=0, out=tmp_path / "fit", progress=False)
    slopes, residuals = fit.sensitivity["stress"].to_numpy() / 1e-3, fit.table["residual"].to_numpy()
    one = np.log(fit.leave_one_out["stress"]["slow"] / fit.values["stress"])
    whole = -(slopes @ residuals) / (slopes @ slopes)
    assert one == pytest.approx(-residuals[1] / slopes[1] - whole, rel=1e-3, abs=1e-4)
    assert fit.uncertainty["stress"] == pytest.approx(1.0 / np.linalg.norm(slopes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"measure": "width"}, "row 1: measure: found 'width', expected depth, slope or cavity"),
        ({"band": 0.0}, "row 1: band: found 0.0, expected a number above 0"),
        ({"value": "deep"}, "row 1: value: found 'deep', expected a number"),
        ({"limit": "wide"}, "row 1: limit: found 'wide', expected a number above 0"),
        ({"window": -1.0}, "row 1: window: found -1.0, expected 0 or a positive number"),
        ({"speed": "fast"}, "row 1: speed: found 'fast', expected a speed above 0"),
        ({"speed": "195/165", "measure": "slope"}, "two speeds of a slope, the lower first"),
        ({"speed": "165", "measure": "slope"}, "of a slope two, the lower first"),
        ({"limit": 0.0}, "row 1: limit: found 0.0, expected a number above 0"),
        ({"widow": 1.0}, "unknown column of shots `widow` .did you mean `window`"),
    ],
)
def test_a_faulty_shot_is_refused_with_row_column_found_and_expected(changes, message):
    row = {"name": "a", "speed": 180, "measure": "depth", "value": 0.085, "band": 1e-3, **changes}
    with pytest.raises(bg.GelfmuError, match=message):
        read_shot_table(pd.DataFrame([row]))


def test_a_fit_without_sense_is_refused_before_a_run(tmp_path):
    shots = _shots(("bb", 60, "depth", 0.0181, 5e-4))
    out = tmp_path / "fit"
    for given, message in [
        ({"parameters": ["stress", "shear_modulus"]}, "shots: found 1, expected at least 2"),
        ({"parameters": ["strength"]}, "unknown parameter `strength`"),
        ({"parameters": ["rate"]}, "rate: found none in the scene of bb"),
        ({"parameters": ["stress"], "without": ["b"]}, "unknown shot `b`"),
    ]:
        with pytest.raises(bg.GelfmuError, match=message):
            bg.fit_gel(shots, scene=_small(), out=out, progress=False, **given)
    for file in ("nowhere.csv", "/dev/zero"):
        with pytest.raises(bg.GelfmuError, match=f"shots {file}: found .*expected a CSV file, or one of gelatin-10"):
            bg.fit_gel(file, out=out)
    with pytest.raises(bg.GelfmuError, match="start: stress: found '1 MPa', expected a number above 0"):
        bg.fit_gel(shots, ["stress"], scene=_small(), start={"stress": "1 MPa"}, out=out)
    assert not out.exists()


def test_a_shot_without_a_value_ends_the_fit_by_name(tmp_path):
    through = _shots(("through", 60, "depth", 0.01, 1e-3)).assign(set="gel.shape.cylinder.height=0.01")
    with pytest.raises(bg.GelfmuError, match="through: the projectile left the block"):
        bg.fit_gel(through, ["stress"], scene=_small(), out=tmp_path / "fit", progress=False)


def test_the_table_of_the_preset_has_measured_shots_and_parameters_of_its_gel():
    table, known = read_shot_table("gelatin-10"), set(bg.measured_shots()["name"])
    assert len(table) == 10 and set(table["scene"]) <= known | {"fbi-bb", "sphere-720"}
    assert set(PARAMETERS) > {"stress", "rate", "shear_modulus"}


# Gel of the cases below, in which no shot is run.
GEL = {"shear_modulus": 2e4, "branches": [{"shear_modulus": 1e7, "power_law": {"stress": 1e6, "exponent": 0.9}}]}


def _model(law, shots, parameters):
    """Return a model whose computed values are those of a law of the parameters, one for each shot."""

    def run(scenes, labels):
        count = len(shots)
        points = [labels.iloc[i] for i in range(0, len(labels), count)]
        values = np.concatenate([law(*(point[name] for name in parameters)) for point in points])
        rows = {"status": "completed", "reason": None, "perforated": np.isnan(values), "final_velocity[3]": 0.0}
        return pd.DataFrame({**rows, "rest_depth": values, "final_depth": values})

    table = read_shot_table(shots)
    scenes = [[bg.Scene.built_in("fbi-bb")] for _ in range(len(table))]
    return ShotModel(table, parameters, scenes, [GEL] * len(table), run)


def _depths(*values, window=0.0, band=1e-3):
    return _shots(*((f"shot {i}", 100 + i, "depth", value, band, window) for i, value in enumerate(values)))


def _fitted(model, steps=15):
    first = np.log([{"stress": 1e6, "shear_modulus": 2e4, "exponent": 0.9}[name] for name in model.parameters])
    return _fit(model, first, steps, import_scipy())


def _power(stress, modulus):
    """Depths that fall with both parameters."""
    a, b = stress / 1e6, modulus / 2e4
    return np.array([0.08 * a**-0.5 * b**-0.05, 0.3 * a**-0.3 * b**-0.4, 0.04 * a**-0.1 * b**-0.3])


def test_a_fit_finds_the_parameters_of_a_law():
    fit = _fitted(_model(_power, _depths(*_power(1.6e6, 1.2e4)), ["stress", "shear_modulus"]))
    assert fit.status == "fitted"
    assert fit.values["stress"] == pytest.approx(1.6e6, rel=0.01)
    assert fit.values["shear_modulus"] == pytest.approx(1.2e4, rel=0.02)


def test_a_step_to_a_shot_without_a_value_is_shortened():
    def through(stress, modulus):
        return np.where(stress < 0.8e6, np.nan, _power(stress, modulus))

    fit = _fitted(_model(through, _depths(*_power(0.85e6, 2e4)), ["stress", "shear_modulus"]))
    assert fit.status == "fitted" and fit.values["stress"] == pytest.approx(0.85e6, rel=0.02)


def test_a_fit_whose_shots_are_in_their_windows_is_fitted_at_once():
    fit = _fitted(_model(_power, _depths(*_power(1.01e6, 2e4), window=5e-3), ["stress", "shear_modulus"]))
    assert fit.status == "fitted" and fit.values["stress"] == 1e6
    assert np.isinf(fit.uncertainty).all() and fit.leave_one_out.isna().all().all()


def test_an_exponent_stays_at_its_bound():
    shots = _depths(0.05, 0.06)
    fit = _fitted(_model(lambda exponent: 0.1 * exponent ** np.array([0.1, 0.2]), shots, ["exponent"]))
    assert 0.0 < fit.values["exponent"] <= 1.0
    high = _fitted(_model(lambda exponent: 0.1 * exponent ** np.array([0.1, 0.2]), _depths(0.2, 0.2), ["exponent"]))
    assert high.values["exponent"] <= 1.0


def test_a_parameter_that_no_shot_decides_has_no_finite_deviation():
    def law(stress, _):
        return np.array([0.08, 0.3]) * (stress / 1e6) ** -0.5

    point = np.log([1e6, 2e4])
    fit = _conclude("fitted", point, point + 1.0, _model(law, _depths(0.08, 0.3), ["stress", "shear_modulus"]))
    assert np.isfinite(fit.uncertainty["stress"]) and np.isinf(fit.uncertainty["shear_modulus"])


def test_a_shot_that_moves_into_its_window_without_another_has_no_residual_then():
    shots = pd.concat([_depths(0.08), _depths(0.02, window=0.5).assign(name="wide")])
    model = _model(lambda stress: np.array([0.1, 0.3]) * (stress / 1e6) ** -0.5, shots, ["stress"])
    fit = _conclude("fitted", np.log([1e6]), np.log([2e6]), model)
    assert fit.leave_one_out["residual"]["wide"] == 0.0 and fit.table["residual"]["wide"] == 0.0


def test_a_gel_without_branches_has_none_of_their_parameters():
    with pytest.raises(bg.GelfmuError, match="stress: found none in the scene of bb"):
        bg.fit_gel(_shots(("bb", 5, "depth", 0.01, 1e-3)), ["stress"], scene="ball-bounce", progress=False)
    assert gel_overrides(GEL, {"stress": 2e6})["gel.branches"][0]["power_law"]["stress"] == 2e6
