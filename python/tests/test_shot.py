"""Tables, data sets, frames and figures of a shot."""

import math

import pytest

import ballistic_gel as bg
from ballistic_gel.columns import split_unit

PLOTS = ("velocity", "velocity_by_depth", "force", "yaw", "energy_per_cm", "wound_profile", "energy")


def test_a_deep_shot_has_all_tables(deep):
    assert deep.tables == ("history", "by_depth", "cavity", "track", "cracks")
    assert deep.history["time_s"].iloc[-1] == pytest.approx(1e-3)
    assert deep.by_depth["velocity_m_per_s"].is_monotonic_decreasing
    # The figure counts from one diameter of the projectile down, the table from the entry.
    below = deep.cavity[deep.cavity["depth_m"] >= 4.37e-3]
    assert deep.summary["greatest_cavity_diameter"] == below["diameter_m"].max()


def test_cracks_follow_from_the_cavity_of_each_slice(deep):
    cracks = deep.cracks
    assert len(cracks) == len(deep.summary["energy_per_centimetre"])
    assert cracks["energy_J"].tolist() == deep.summary["energy_per_centimetre"]
    assert cracks["depth_to_m"].iloc[-1] == pytest.approx(deep.summary["peak_depth"], rel=1e-6)
    cavity = deep.cavity
    for row in cracks.itertuples():
        inside = cavity["depth_m"].between(row.depth_from_m - 1e-9, row.depth_to_m + 1e-9)
        below = inside & (cavity["depth_m"] > row.tear_diameter_m)
        assert row.cavity_diameter_m == pytest.approx(cavity[below]["diameter_m"].max(), nan_ok=True)
    beyond = (cracks["cavity_diameter_m"] - cracks["tear_diameter_m"]).clip(lower=0.0)
    assert cracks["crack_length_m"].tolist() == pytest.approx((math.pi * beyond).tolist(), nan_ok=True)
    assert cracks["crack_length_m"].max() > 0.0


def test_layers_share_the_energy_that_is_given_to_the_gel(layered, deep):
    layers = layered.layers
    assert layers["layer"].tolist() == ["NA", "layer-2", "gel"]
    assert layers["depth_from_m"].tolist() == pytest.approx([0.0, 0.01, 0.018])
    assert layers["depth_to_m"].tolist()[:-1] == layers["depth_from_m"].tolist()[1:]
    assert layers["energy_J"].sum() == pytest.approx(sum(layered.summary["energy_per_centimetre"]))
    assert layers["energy_fraction"].sum() == pytest.approx(1.0)
    assert layers["entry_speed_m_per_s"].is_monotonic_decreasing and layers["entry_speed_m_per_s"].iloc[-1] > 100.0
    assert "layers" in layered.tables
    assert deep.layers.empty and list(deep.layers.columns) == list(layers.columns)


def test_the_data_set_has_the_layers_by_name(layered):
    pytest.importorskip("xarray")
    data = layered.to_xarray()
    assert data["layer"].to_numpy().tolist() == ["NA", "layer-2", "gel"]
    assert data["entry_speed_by_layer"].dims == ("layer",)
    assert data["entry_speed_by_layer"].attrs["units"] == "m/s"
    assert data["density_by_layer"].attrs["units"] == "kg/m3"


def test_a_table_that_is_missing_says_why(quick, tmp_path):
    shot = bg.run(quick, out=tmp_path / "q", frames=False, report=False)
    with pytest.raises(bg.GelfmuError, match="goes deeper along -z") as missing:
        shot.cavity  # noqa: B018
    assert missing.value.remedy == "Shot.tables lists its tables"
    with pytest.raises(bg.GelfmuError, match="no frames"):
        len(shot.frames)
    with pytest.raises(bg.GelfmuError, match="no such table"):
        shot.plot.energy_per_cm()
    with pytest.raises(bg.GelfmuError, match="found no summary"):
        bg.Shot.load(tmp_path)
    assert shot.plot.force().get_xlabel() == "time, ms"


@pytest.mark.parametrize(
    "text, told",
    [
        (b"", "Expecting value"),
        (b"{", "Expecting"),
        (b"\xff", "utf-8"),
        (b"[]", "list in the place of figures"),
        (b'{"format": 2}', "without scene, completed, doubts, digest, ended_by"),
    ],
)
def test_a_damaged_summary_is_told_with_the_remedy(tmp_path, text, told):
    (tmp_path / "summary.json").write_bytes(text)
    with pytest.raises(bg.GelfmuError, match=rf"summary\.json: found a damaged summary \(.*{told}") as damaged:
        bg.Shot.load(tmp_path)
    assert damaged.value.remedy.endswith("run it again")
    (tmp_path / "history.csv").write_bytes(text)
    if not text.startswith((b"{", b"[]")):
        with pytest.raises(bg.GelfmuError, match="found a damaged table"):
            bg.Shot(tmp_path).history  # noqa: B018


@pytest.mark.parametrize(
    "text, told",
    [
        ("{}", "no format, in the place of format 2"),
        ('{"format": 1, "version": "9.1.0"}', "format 1, written by gelfmu 9.1.0, in the place of format 2"),
    ],
)
def test_a_summary_of_another_release_names_it_and_the_remedy(tmp_path, text, told):
    (tmp_path / "summary.json").write_text(text)
    with pytest.raises(bg.GelfmuError, match=rf"summary\.json: found {told}: run its scene\.toml, or pack the FMU"):
        bg.Shot.load(tmp_path)


@pytest.mark.parametrize("name", PLOTS)
def test_each_figure_draws_into_the_axes_that_it_is_given(deep, name):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots()
    assert getattr(deep.plot, name)(axes) is axes
    assert axes.has_data() and axes.get_xlabel() and axes.get_ylabel()
    plt.close(figure)


def test_the_energy_ledger_adds_up(deep):
    ax = deep.plot.energy()
    total = sum(line.get_ydata()[-1] for line in ax.lines)
    assert total == pytest.approx(deep.summary["energy"]["initial"], rel=0.05)


def test_the_data_set_has_units_and_axes(deep):
    pytest.importorskip("xarray")
    data = deep.to_xarray()
    rows = len(deep.history)
    assert data["velocity"].shape == (rows, 3)
    assert data["orientation"].shape == (rows, 4)
    assert data["depth"].shape == (rows,)
    assert data["velocity"].attrs["units"] == "m/s"
    assert data["cavity_diameter"].dims == ("cavity_time", "cavity_depth")
    assert data["velocity_by_depth"].shape == (len(deep.by_depth),)
    assert data["track_diameter"].shape == (len(deep.track),)
    assert data["crack_length_by_slice"].dims == ("slice_depth",)
    assert data["crack_length_by_slice"].shape == (len(deep.cracks),)
    assert data.attrs["digest"] == deep.digest


@pytest.mark.parametrize(
    "column, quantity, unit",
    [
        ("velocity_x_m_per_s", "velocity_x", "m/s"),
        ("angular_impulse_z_N_m_s", "angular_impulse_z", "N m s"),
        ("contact_area_m2", "contact_area", "m2"),
        ("density_kg_per_m3", "density", "kg/m3"),
        ("remeshes", "remeshes", "1"),
    ],
)
def test_the_end_of_a_column_is_its_unit(column, quantity, unit):
    assert split_unit(column) == (quantity, unit)


def test_frames_are_meshes_at_their_times(deep):
    pytest.importorskip("pyvista")
    assert len(deep.frames) == len(deep.frames.times) == 3
    last = deep.frames[-1]
    assert last.time == deep.frames.at(1.0).time == pytest.approx(1e-3)
    assert last.gel.n_cells > 100 and len(last.bodies) == 1
    assert [frame.time for frame in deep.frames[:2]] == deep.frames.times[:2]
    with pytest.raises(IndexError):
        deep.frames[3]


def test_a_notebook_shows_the_key_figures(deep):
    page = deep._repr_html_()
    assert "temporary cavity" in page and deep.digest in page


def test_the_caption_of_a_figure_names_what_it_depends_on(deep):
    captions = list(deep.figures())
    assert f"peak force, mean over {1e6 * deep.summary['force_window']:.4g} µs, N" in captions
    assert any("still opening" in caption for caption in captions) == deep.summary["cavity_still_opening"]
    deep.summary["cavity_still_opening"] = True
    assert "temporary cavity, greatest diameter, still opening, mm" in deep.figures()
    deep.__dict__.pop("summary")


def test_a_report_is_made_afterwards_with_the_curve_of_a_laboratory(deep, tmp_path):
    assert not (deep.folder / "report.html").exists()
    assert "Compared with the laboratory" not in deep.report().read_text(encoding="utf-8")
    table = tmp_path / "lab.csv"
    table.write_text("depth_mm,velocity_m_per_s\n0,180\n5,150\n", encoding="utf-8")
    assert "Compared with the laboratory" in deep.report(measured=table).read_text(encoding="utf-8")
    assert len(deep.summary["measured"]["curves"]) == len(deep.measured) == 1
    with pytest.raises(bg.GelfmuError, match=r"nowhere\.csv"):
        deep.report(measured=tmp_path / "nowhere.csv")
