"""Calibration: a fit that fails is told."""

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
