"""Validation: a shot from the run to the table, and what counts."""

import numpy as np
import pandas as pd
import pytest

import ballistic_gel as bg
from ballistic_gel.validation import _cases_of, _result_of


def test_a_shot_is_run_compared_and_taken_up_again(tmp_path):
    given = {"only": ["45acp-185-remington"], "out": tmp_path / "valid", "workers": 1, "progress": False}
    found = bg.validate(**given)
    [shot] = found.table.to_dict("records")
    assert 0.2 < shot["computed"] < 0.35 and shot["agrees"] and not shot["judged"] and shot["level"] == "standard"
    assert found.judged == found.agreeing == 0 and 30.0 < shot["energy"] < 200.0
    text = (tmp_path / "valid" / "validation.md").read_text()
    assert text == found.to_markdown() and "| 45acp-185-remington | depth | 267 | B, fitted | standard | 26" in text
    assert "measured, mm" in (tmp_path / "valid" / "validation.svg").read_text()
    [row] = (tmp_path / "valid" / "runs" / "rows").iterdir()
    depth = float(found.runs["final_depth"][0])
    row.write_text(row.read_text().replace(f'"final_depth": {depth!r}', '"final_depth": 0.123'))
    again = bg.validate(**given)
    assert again.runs["final_depth"][0] == 0.123, "the kept row is used"
    with pytest.raises(bg.GelfmuError, match="unknown measured shot `x`"):
        bg.validate(["x"], out=tmp_path / "other")


def test_a_bullet_that_yaws_is_run_with_its_scatter_and_others_once():
    shots = bg.measured_shots().set_index("name", drop=False)
    tumbling, straight = (shots.loc[name].copy() for name in ("762-m80-neck", "bb-fbi"))
    tumbling["is_tumbling"], straight["is_tumbling"] = True, False
    cases = _cases_of(tumbling, None)
    assert [(case["level"], case["yaw"]) for case in cases] == [
        ("coarse", 2),
        ("draft", 1.0),
        ("draft", 2.0),
        ("draft", 4.0),
    ]
    assert cases[0]["scene"]["scene.end_time"] == pytest.approx(2.0 * 0.15 / 840.0)
    assert [case["level"] for case in _cases_of(straight, None)] == ["standard"]
    assert _cases_of(straight, "draft") == []


def test_a_run_that_did_not_get_there_does_not_agree():
    shot = bg.measured_shots().set_index("name", drop=False).loc["45acp-fmj-869"].copy()
    shot["is_tumbling"] = True
    run = {"shot": shot["name"], "level": "coarse", "status": "completed", "final_depth": 0.6, "perforated": False}
    good = _result_of(shot, pd.DataFrame([run]))
    assert good["agrees"] and good["judged"] and good["deviation"] == pytest.approx(0.6 / 0.66 - 1.0)
    for changes in ({"status": "stopped"}, {"perforated": True}):
        bad = _result_of(shot, pd.DataFrame([{**run, **changes}]))
        assert not bad["agrees"] and np.isnan(bad["computed"]) and bad["has_run"]
    assert not _result_of(shot, pd.DataFrame([{**run, "level": "draft"}]))["has_run"]
