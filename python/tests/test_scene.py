"""Keys, values and errors of scenes."""

import pickle

import numpy as np
import pytest

import ballistic_gel as bg
from ballistic_gel.scene import as_scene
from ballistic_gel.schema import check_key, scene_keys
from ballistic_gel.values import toml_text


def test_a_key_that_no_scene_has_is_refused_with_the_nearest_one(quick):
    with pytest.raises(bg.GelfmuError, match="did you mean `mesh.size`") as refused:
        quick.with_values({"mesh.sizee": 1e-3})
    assert refused.value.key == "mesh.sizee"
    assert refused.value.remedy == "did you mean `mesh.size`?"


def test_all_keys_of_the_schema_are_known():
    assert {"gel.branches.power_law.stress", "projectile.shape.bullet.nose.ogive.length"} <= set(scene_keys())
    check_key("fragment[1].mass")
    check_key("projectile.velocity[3]")


def test_a_value_that_the_program_refuses_names_key_and_remedy(quick):
    with pytest.raises(bg.GelfmuError) as refused:
        quick.with_values({"mesh.size": -1.0}).check()
    assert refused.value.key == "mesh.size"
    assert refused.value.remedy.startswith("expected a positive length")


@pytest.mark.parametrize(
    "key, value",
    [
        ("mesh.size", "2 kg"),
        ("mesh.size", "2 mm 3"),
        ("mesh.size", "coarse"),
        ("projectile.velocity", [0.0, 0.0, "3 g"]),
        ("projectile.velocity[3]", "3 g"),
        ("fragment", [{"mass": "3 m"}]),
        ("scene.stop_after_exit", "3 m"),
    ],
)
def test_a_unit_of_another_quantity_is_refused_at_once(quick, key, value):
    with pytest.raises(bg.GelfmuError, match='found .*, expected a number in .*, such as "') as refused:
        quick.with_values({key: value})
    assert refused.value.key.startswith(key.partition("[")[0]) and refused.value.remedy.startswith("expected a number")


def test_texts_that_gelfmu_reads_are_taken(quick):
    taken = {"mesh.size": " 2.5e3um", "scene.end_time": ".2 ms", "scene.stop_after_exit": "never"}
    taken |= {"projectile.velocity": [0.0, 0, "-3 ft/s"], "gel.density": "1.03 g/cm3", "scene.title": "9 mm"}
    assert quick.with_values(taken).check().values["bodies"][0]["velocity"][2] == pytest.approx(-0.9144)


def test_a_replaced_key_is_read_back_and_the_original_stays(quick):
    changed = quick.with_values({"projectile.velocity[3]": -3.0})
    assert changed["projectile.velocity"] == [0.0, 0.0, -3.0]
    assert changed["projectile.velocity[3]"] == -3.0
    assert quick["projectile.velocity[3]"] == -1.0
    assert changed.digest() != quick.digest()
    with pytest.raises(bg.GelfmuError, match="only the default") as absent:
        quick["integrator.cfl"]
    assert absent.value.key == "integrator.cfl"


def test_a_component_that_is_not_there_is_refused(quick):
    with pytest.raises(bg.GelfmuError, match="found no value"):
        quick["projectile.velocity[4]"] = 1.0
    with pytest.raises(bg.GelfmuError, match="set the whole key first"):
        quick["projectile.angular_velocity[3]"] = 1.0
    fragments = quick.with_values({"fragment": [{"mass": 1e-3}]})
    assert fragments["fragment[1].mass"] == 1e-3


def test_the_program_gets_the_replaced_values(quick):
    body = quick.with_values({"projectile.velocity[3]": -3.0}).check().values["bodies"][0]
    assert body["velocity"] == [0.0, 0.0, -3.0]


@pytest.mark.parametrize(
    "value, text",
    [
        (True, "true"),
        (np.float64(1e-05), "1e-05"),
        (np.array([0, 1]), "[0, 1]"),
        ('1.5 "mm"', '"1.5 \\"mm\\""'),
        ({"c1": 2.0}, "{c1 = 2.0}"),
    ],
)
def test_values_are_written_as_toml(value, text):
    assert toml_text(value) == text


def test_a_value_that_toml_cannot_represent_is_refused(quick):
    with pytest.raises(TypeError, match="NoneType"):
        quick["mesh.size"] = None


def test_a_shot_of_the_library_is_a_scene():
    scene = bg.Scene.new_shot("bb", speed="590 ft/s", block=(0.1, 0.1, 0.2), gel="20%")
    assert scene["gel.preset"] == "gelatin-20"
    assert scene["projectile.velocity"][2] == pytest.approx(-179.832)
    with pytest.raises(bg.GelfmuError, match="did you mean `9mm-fmj`"):
        bg.Scene.new_shot("9mm-fmjj")
    assert "bb" in set(bg.projectiles()["name"])
    assert "fbi-bb" in set(bg.scenes()["name"])


def test_a_scene_file_that_changed_after_it_was_read_is_refused(quick, tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(quick.text)
    scene = bg.Scene.load(path)
    assert scene.check().elements > 0
    assert as_scene(str(path)).digest() == scene.digest()
    path.write_text(quick.text + "\n# changed\n")
    with pytest.raises(bg.GelfmuError, match="changed after it was read"):
        scene.check()


def test_a_text_that_is_no_scene_is_told(tmp_path):
    (tmp_path / "latin.toml").write_bytes(b"# \xe9")
    with pytest.raises(bg.GelfmuError, match=r"latin\.toml: .*utf-8"):
        bg.Scene.load(tmp_path / "latin.toml")
    with pytest.raises(bg.GelfmuError, match="scene"):
        bg.Scene("scene = 5").check()
    with pytest.raises(bg.GelfmuError, match="^block: found 5, expected three lengths"):
        bg.Scene.new_shot("bb", block=5)


def test_a_scene_travels_between_processes(quick):
    assert pickle.loads(pickle.dumps(quick)).digest() == quick.digest()


def test_a_missing_program_is_told_with_the_remedy(monkeypatch, tmp_path):
    monkeypatch.setenv("GELFMU", str(tmp_path / "none"))
    with pytest.raises(bg.GelfmuError, match="found no file") as missing:
        bg.find_binary()
    assert "GELFMU" in missing.value.remedy
