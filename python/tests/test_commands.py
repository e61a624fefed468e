"""Lists, and a calibration that fails."""

import sys

import pytest

import ballistic_gel as bg

NOT_FITTED = '{"status": "not fitted", "strength_scale": 0.5, "lines": "[gel]", "trials": []}'


@pytest.mark.skipif(sys.platform == "win32", reason="the program is a shell script")
def test_a_gel_that_is_not_fitted_is_a_warning_with_the_reason(tmp_path, monkeypatch):
    script = tmp_path / "gelfmu"
    told = f"echo '{NOT_FITTED}'; echo 'error: gel.strength_scale was not fitted: no run stops' >&2; exit 1"
    script.write_text(f'#!/bin/sh\nif [ "$1" = calibrate ]; then {told}; fi\nexec "{bg.find_binary()}" "$@"\n')
    script.chmod(0o755)
    monkeypatch.setenv("GELFMU", str(script))
    with pytest.warns(bg.FitWarning, match="^gel.strength_scale was not fitted: no run stops$"):
        calibration = bg.calibrate("fbi-bb", level="draft")
    assert calibration.status == "not fitted" and calibration.strength_scale == 0.5


def test_the_table_of_figures_has_the_unit_of_every_number_of_a_run(deep):
    figures = bg.figures()
    assert figures.loc["rest_depth", ["unit", "sampled"]].tolist() == ["m", "step"]
    assert figures.loc["sensors.dent.depth", "unit"] == "m" and figures["meaning"].str.len().min() > 3
    numbers = [key for key, value in deep.summary.items() if type(value) in (int, float) and key != "format"]
    numbers += [f"energy.{account}" for account in deep.summary["energy"]]
    assert (figures.loc[numbers, "unit"] != "").all() and (figures.loc[numbers, "sampled"] != "").all()
