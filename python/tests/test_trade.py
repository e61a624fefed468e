"""Error-cost curves: the limit of refinement, the choice of levels, and a small scene from run to table."""

import numpy as np
import pandas as pd
import pytest

import ballistic_gel as bg
from ballistic_gel.knobs import MESH, REMESHED, ladder
from ballistic_gel.richardson import NoLimit, extrapolate_limit
from ballistic_gel.tables import digits, markdown
from ballistic_gel.trade import build_curve

# A disc falls on a small slice of gel, on 200 elements.
TINY = """
[scene]
name = "tiny"
dimension = "planar"
end_time = 4e-3
communication_step = 20e-6

[gel]
shape.block.size = [0.06, 0.03]
material = "neo-hookean"
density = 1030.0
shear_modulus = 70e3
bulk_modulus = 350e3
supports.z_min = "fixed"

[projectile]
shape.sphere.radius = 0.010
mass = 0.5
position = [0.0, 0.0, 0.010]
velocity = [0.0, 0.0, -2.0]

[mesh]
size = 6e-3
"""


@pytest.mark.parametrize(
    ("order", "sizes"),
    [(1.0, (4.0, 2.0, 1.0)), (2.0, (5.0, 3.57, 2.5)), (0.7, (2.0, 1.41, 1.0)), (1.5, (3.0, 2.0, 1.0))],
)
def test_a_power_law_gives_back_its_order_and_limit_for_any_three_sizes(order, sizes):
    values = [14.5 - 0.03 * size**order for size in sizes]
    found = extrapolate_limit(sizes, values)
    assert (found.order, found.value) == (pytest.approx(order, abs=1e-9), pytest.approx(14.5, abs=1e-10))
    assert found.reach == pytest.approx(0.03 / 14.5 * sizes[2] ** order, abs=1e-10)
    assert extrapolate_limit(sizes, values, scale=29.0).reach == pytest.approx(0.5 * found.reach, rel=1e-6)


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ((1.0, 2.0, 1.5), "not monotone"),
        ((1.0, 1.0, 1.0), "not monotone"),
        ((1.0, float("nan"), 1.0), "not monotone"),
        ((1.0, 2.0, 4.0), "no order"),
        ((-1.0, 0.0, 0.5), "the finest is 50 % away"),
    ],
)
def test_values_that_oscillate_diverge_or_end_far_away_have_no_limit(values, why):
    with pytest.raises(NoLimit, match=why):
        extrapolate_limit((4.0, 2.0, 1.0), values)


def _run(knob, refinement, size, **changes):
    """Return a run of a size with first-order errors, 1 % at size 1, and a cost of h to the power -3."""
    values = {} if size == 1.0 else {"mesh.size": size}
    return {
        "knob": knob,
        "run": f"size {size}",
        "refinement": refinement,
        "size": size if knob in ("", MESH) else None,
        "values": values,
        "status": "completed",
        "reason": None,
        "elements": 100,
        "remeshes": 0,
        "element_updates": 1e6 * size**-3,
        "cpu_seconds": size**-3,
        "peak_depth": 0.01 * (1.0 - 0.01 * size),
        "contact_duration": np.nan,
        "final_speed": 3.0 + np.sin(9.0 * size),
        "initial_speed": 5.0,
        "peak_force": 100.0 * (1.0 + 0.005 * size * size),
        **changes,
    }


def _mesh(size, **changes):
    return _run("" if size == 1.0 else MESH, np.log2(1.0 / size), size, **changes)


def test_errors_are_those_of_the_law_and_absent_without_a_limit():
    failed = _run("cfl", -1.0, 1.0, status="stopped", reason="inverted")
    curve = build_curve(pd.DataFrame([*map(_mesh, (1.0, 1.4, 0.7, 0.5)), failed]))
    good = curve.runs.iloc[:4]
    assert np.allclose(good["peak_depth_error"], 0.01 * good["size"].astype(float), atol=1e-9)
    assert np.allclose(good["peak_force_error"], 0.005 * good["size"].astype(float) ** 2, atol=1e-9)
    assert good["best"].all() and (good["worst"] == good["peak_depth_error"]).all()
    assert curve.limits["contact_duration"] == "fewer than three meshes have it"
    assert "not monotone" in curve.limits["final_speed"] or "no order" in curve.limits["final_speed"]
    assert np.isnan(curve.runs["worst"].iloc[4]) and not curve.runs["best"].iloc[4]
    text = curve.to_markdown()
    assert "- size 1.0: stopped: inverted" in text and "depth: 10.000 mm, the limit of refinement" in text


def test_a_remeshed_run_is_compared_with_runs_twice_as_fine():
    remeshed = [_mesh(size, remeshes=1) for size in (4.0, 2.0, 1.0, 0.5)]
    shifted = [_mesh(size, remeshes=1, peak_depth=0.01 + 1e-4 * np.sin(size)) for size in (2.8, 1.4, 0.7)]
    limit = build_curve(pd.DataFrame([*remeshed, *shifted])).limits["peak_depth"]
    assert (limit.value, limit.order) == (pytest.approx(0.01, abs=1e-9), pytest.approx(1.0, abs=1e-6))
    assert isinstance(build_curve(pd.DataFrame(remeshed[1:3])).limits["peak_depth"], str)


def test_a_chance_hit_takes_the_error_of_finer_runs():
    runs = [_mesh(size) for size in (2.0, 1.4, 1.0, 0.7, 0.5)]
    runs[0]["peak_depth"] = 0.01
    runs[0]["peak_force"] = 100.0
    curve = build_curve(pd.DataFrame(runs))
    assert curve.runs["worst"].iloc[0] < 1e-6 and curve.runs["confirmed"].iloc[0] == pytest.approx(0.014, rel=1e-2)


def test_a_level_is_the_best_for_its_cost_and_costs_more_only_if_it_is_better():
    sizes = (6.0, 4.0, 3.0, 2.0, 1.5, 1.0, 0.8, 0.7, 0.5, 0.4, 0.3)
    curve = build_curve(pd.DataFrame(map(_mesh, sizes)))
    errors = {level: found["error"] for level, found in curve.levels.items()}
    assert errors == {"draft": 0.02, "coarse": 0.015, "standard": 0.01, "fine": 0.007, "reference": 0.004}
    few = build_curve(pd.DataFrame(map(_mesh, (1.4, 1.0, 0.8, 0.7))))
    assert list(few.levels) == ["coarse", "standard", "fine"]
    assert few.lines.startswith('[fidelity.coarse]\nset = ["mesh.size=1.4"]\nerror = 0.014\n')


def test_a_run_without_a_finer_one_of_its_knob_is_no_level():
    meshes = [_mesh(size) for size in (1.0, 0.7, 0.5)]
    one = build_curve(pd.DataFrame([*meshes, _run("grading", 1.0, 0.65)]))
    two = build_curve(pd.DataFrame([*meshes, _run("grading", 1.0, 0.65), _run("grading", 2.0, 0.6)]))
    assert (one.levels["fine"]["error"], two.levels["fine"]["error"]) == (0.007, 0.0065)


def test_a_table_of_no_rows_is_empty_and_numbers_have_their_digits():
    assert markdown([]) == ""
    assert markdown([{"a": "1", "b": ""}]) == "| a | b |\n| --- | --- |\n| 1 |  |\n"
    assert [digits(value) for value in (0.0, 0.01234, 1.234, 51837.0)] == ["0.00", "0.0123", "1.23", "51837"]


def test_every_rung_of_every_built_in_scene_is_a_scene():
    for name in bg.scenes()["name"]:
        scene = bg.Scene.built_in(name)
        checked = scene.check().values
        rungs = ladder(checked, 1, has_failed=name == "ball-square")
        for rung in rungs:
            turned = scene.with_values(rung.values)
            if rung.refinement > 0.0 and checked["elements"] < 20_000:
                turned.check()
    families = {rung.knob for rung in ladder(bg.Scene.built_in("ball-square").check().values, 1, has_failed=True)}
    assert REMESHED in families
    finer = next(
        rung
        for rung in ladder(bg.Scene.built_in("ball-bounce").check().values)
        if rung.knob == MESH and rung.refinement == 2
    )
    assert finer.label == "mesh.size=0.0005 mesh.grading.growth=1.072 mesh.grading.largest=0.003"


def test_a_curve_is_measured_written_and_taken_up_again(tmp_path):
    scene = tmp_path / "tiny.toml"
    scene.write_text(TINY)
    others = tmp_path / "others.csv"
    others.write_text("run,peak_depth,cpu_seconds\nanother code,0.009,12.5\n")
    given = {"only": ["cfl"], "finer": 2, "others": others, "out": tmp_path / "curve", "progress": False}
    curve = bg.error_cost(scene, **given)
    runs = curve.runs.set_index("run")
    assert runs["element_updates"]["mesh.size=0.003"] > runs["element_updates"]["as it is"]
    assert runs["status"]["mesh.size=0.012"] == "refused" and "mesh.size" in runs["reason"]["mesh.size=0.012"]
    assert (runs["cpu_seconds"].dropna() > 0.0).all() and set(curve.runs["knob"]) == {"", MESH, "mesh, graded", "cfl"}
    assert "another code" in (tmp_path / "curve" / "trade.svg").read_text()
    again = bg.error_cost(scene, **given)
    assert again.to_markdown() == curve.to_markdown() == (tmp_path / "curve" / "trade.md").read_text()
    with pytest.raises(bg.GelfmuError, match="unknown knob of tiny `speed`"):
        bg.error_cost(scene, only=["speed"], out=tmp_path / "other")
    others.write_text("run,cpu_seconds\na,soon\n")
    with pytest.raises(bg.GelfmuError, match="others .*expected columns run, cpu_seconds"):
        bg.error_cost(scene, others=others, out=tmp_path / "other")


def test_options_that_are_off_leave_the_bits_and_those_that_are_on_are_counted(tmp_path):
    scene = tmp_path / "tiny.toml"
    scene.write_text(TINY)
    costs = bg.option_costs(scene, out=tmp_path / "options", progress=False).set_index("run")
    off = ["contact.friction=0.0", "integrator.damping=0.0", "load=[]", 'mesh.element="plain"', "fragment=[]"]
    assert costs.loc[off, "same_bits"].all() and not costs["same_bits"]["integrator.damping=1.0"]
    assert costs["element_updates_ratio"]["as it is"] == 1.0
    assert "| friction | contact.friction=0.0 | completed | True |" in (tmp_path / "options" / "options.md").read_text()
    missing = tmp_path / "missing.csv"
    missing.write_text("name,cpu_seconds\na,0\n")
    with pytest.raises(bg.GelfmuError, match="found no column run"):
        bg.error_cost(scene, others=missing, out=tmp_path / "other")


def test_a_ladder_of_failures_alone_is_a_curve_without_errors():
    runs = pd.DataFrame([_mesh(1.0, status="refused", reason="no memory"), _mesh(0.7, status="crashed", reason="full")])
    curve = build_curve(runs)
    assert curve.levels == {} and curve.runs["worst"].isna().all() and "refused: no memory" in curve.to_markdown()
