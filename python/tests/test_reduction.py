"""Reduced model: its law in Python and in the program, its identification, and sweeps at the level `instant`."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ballistic_gel as bg
from ballistic_gel import reduced_law, reduction
from ballistic_gel.errors import GelfmuError

ROWS = Path(__file__).parents[2] / "reduced" / "gelatin-10.csv"
SHIPPED = Path(__file__).parents[2] / "reduced" / "gelatin-10.toml"


def shot(**values: float) -> pd.DataFrame:
    """Return rows of one shot."""
    usual = {"diameter": 8e-3, "length": 8e-3, "mass": 3e-3, "speed": 300.0, "thickness": 0.4, "peak_depth": 0.4}
    return pd.DataFrame([{**usual, **values}])


def test_drag_alone_lets_the_speed_decay_with_the_path() -> None:
    """Without shear and spring the speed is v exp(-½ρCA s/m)."""
    names = [*reduced_law.PENETRATION]
    law = {**dict.fromkeys(names, 1e-12), "shear_rate": 1.0, "shear_exponent": 1.0, "entry_path": 1.0, "drag": 0.3}
    depth, exit_speed, speeds = reduced_law.fly(law, shot())
    rate = 0.5 * 1030.0 * 0.3 * math.pi * 16e-6 / 3e-3
    assert depth[0] == 0.4
    assert exit_speed[0] > 0.0
    inside = reduced_law.FRACTIONS < 0.9  # the section fades at the back face
    expected = 300.0 * np.exp(-rate * 0.4 * reduced_law.FRACTIONS)
    assert speeds[0][inside] == pytest.approx(expected[inside], rel=1e-4)


def test_the_program_and_the_fit_have_the_same_law(tmp_path: Path) -> None:
    """Depths and exit speeds agree by the error of their steps."""
    classes = {found["body"]: found for found in tomllib.loads(SHIPPED.read_text())["class"]}
    scene = bg.Scene.new_shot("bb", 170.0)
    for speed in (100.0, 300.0, 700.0):
        values = {"projectile.velocity": [0.0, 0.0, -speed], "gel.shape.cylinder.height": 0.15}
        table = bg.sweep(scene, pd.DataFrame([values]), tmp_path / str(speed), fidelity="instant", progress=False)
        size = {"diameter": 4.37e-3, "length": 4.37e-3, "mass": 0.343e-3, "thickness": 0.15, "speed": speed}
        depth, exits, _ = reduced_law.fly(classes["sphere"]["penetration"], shot(**size))
        assert table["peak_depth"][0] == pytest.approx(depth[0], rel=0.02)
        left = table["exit_velocity[3]"][0]
        assert (0.0 if pd.isna(left) else -left) == pytest.approx(exits[0], rel=0.05)


def test_the_shipped_coefficients_are_those_of_the_shipped_rows() -> None:
    """Identified ranges and numbers of runs follow from the rows."""
    rows = reduction.read_rows(ROWS)
    for found in tomllib.loads(SHIPPED.read_text())["class"]:
        fitted, kept_out = reduction.halves(rows, found["body"])
        assert found["runs"] == len(fitted) == len(kept_out)
        own = rows[rows["body"] == found["body"]]
        assert found["range"]["speed"] == [own["speed"].min(), own["speed"].max()]
        assert found["penetration"]["spring_travel"] == pytest.approx(
            reduced_law.fit_spring(fitted)["spring_travel"], rel=1e-4
        )
        assert found["depth_error"] <= 0.12


def test_rings_are_fitted_to_what_they_are_made_of() -> None:
    """Rows with the rings of known coefficients give these."""
    rows = reduction.read_rows(ROWS)
    rows = rows[rows["body"] == "sphere"].copy()
    for part in reduced_law.RINGS:
        name = f"ring_{round(100 * part):02d}"
        drive = (rows[f"{name}_speed"] / 100.0) * (rows["diameter"] / 8e-3) ** 0.5
        depth = part * np.minimum(rows["peak_depth"], rows["thickness"])
        crater = 1.0 - np.exp(-depth / (3.0 * rows["diameter"]))
        rows[f"{name}_greatest"] = rows["diameter"] * np.sqrt(1.3 + drive**2.5 * crater)
        rows[f"{name}_opening"] = 5e-4 * (rows[f"{name}_greatest"] / 8e-3) ** 1.1
    found = reduced_law.fit_rings(rows)
    expected = {
        "slow_section": 1.3,
        "opening_speed": 100.0,
        "speed_exponent": 2.5,
        "size_exponent": 0.5,
        "crater_depth": 3.0,
    }
    expected |= {"opening_time": 5e-4, "time_exponent": 1.1}
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=1e-3)


def test_a_design_is_in_its_range_and_its_scenes_are_those_of_the_library_scaled() -> None:
    """A scaled scene has calibre, mass, speed and cells in proportion."""
    shots = reduction.design("round-nose", 16)
    assert shots["diameter"].between(3e-3, 20e-3).all()
    assert shots["speed"].between(50.0, 1000.0).all()
    scene = reduction.scaled_scene("round-nose", shots.iloc[3], "coarse")
    assert scene["projectile.shape.bullet.radius"] == pytest.approx(0.5 * shots["diameter"].iloc[3], rel=1e-4)
    assert scene["projectile.mass"] == shots["mass"].iloc[3]
    plain = bg.Scene.new_shot("45acp-230-xtp-recovered")
    ratio = scene["projectile.shape.bullet.radius"] / 9.144e-3
    assert scene["mesh.size"] == pytest.approx(float(str(plain["mesh.size"])) * ratio, rel=2e-2)
    scene.check()


def test_a_sweep_at_the_level_instant_has_the_rows_of_any_sweep(tmp_path: Path) -> None:
    """Refused shots are rows with a reason, and the same call runs nothing again."""
    samples = {"projectile.velocity[3]": [-100.0, -200.0, -5000.0]}
    table = bg.sweep("fbi-bb", samples, tmp_path / "sweep", fidelity="instant", progress=False)
    assert list(table["status"]) == ["completed", "completed", "refused"]
    assert "--fidelity draft" in table["reason"][2]
    assert table["peak_depth"][0] < table["peak_depth"][1] < 0.15
    again = bg.sweep("fbi-bb", samples, tmp_path / "sweep", fidelity="instant", progress=False)
    pd.testing.assert_frame_equal(table, again)
    own = bg.run(
        bg.Scene.built_in("fbi-bb").with_values({"projectile.velocity": [0.0, 0.0, -100.0]}), fidelity="instant"
    )
    assert own.summary["digest"] == table["digest"][0]


def test_unknown_bodies_and_too_few_runs_are_refused(tmp_path: Path) -> None:
    """The message names what is expected."""
    with pytest.raises(GelfmuError, match="sphere or round-nose"):
        bg.reduce_model(["cube"], out=tmp_path)
    with pytest.raises(GelfmuError, match="at least 16"):
        bg.reduce_model(["sphere"], runs=4, out=tmp_path)
    with pytest.raises(GelfmuError, match=r"rows\.csv"):
        (tmp_path / "other.csv").write_text(json.dumps({}))
        bg.reduce_model(["sphere"], rows=tmp_path / "other.csv", out=tmp_path / "out")
