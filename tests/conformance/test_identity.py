"""An archive is known by its GUID, and runs as it was packed or not at all."""

import json
import shutil
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest
import run_system
from fmpy import extract, read_model_description
from fmu_manipulation_toolbox import operations
from own_body import Gel
from test_importers import FOREIGN

STEP, STEPS = 1e-5, 30


def guid(fmu):
    return read_model_description(str(fmu)).guid


def manifest(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return json.loads(archive.read("resources/manifest.json"))


def test_another_scene_has_another_guid_and_the_description_names_it(coarse_fmu, other_fmu):
    fmus = [coarse_fmu, other_fmu]
    assert guid(coarse_fmu) != guid(other_fmu)
    for fmu, scene in zip(fmus, ["sphere-block", "fbi-bb"], strict=True):
        assert manifest(fmu)["guid"] == guid(fmu)
        assert read_model_description(fmu).modelName == f"BallisticGel {scene}"


def test_every_resource_is_in_the_manifest(fmu):
    with zipfile.ZipFile(fmu) as archive:
        names = {n.removeprefix("resources/") for n in archive.namelist() if n.startswith("resources/")}
    assert set(manifest(fmu)["files"]) == names - {"manifest.json"}


def alone(fmu, scratch):
    gel = Gel(extract(fmu, str(scratch)))
    gel.start()
    for k in range(STEPS):
        gel.fmu.doStep(k * STEP, STEP)
    impulse = gel.get("contact.total_impulse")[2]
    gel.free()
    return impulse


SSD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription version="1.0" name="two" xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
 xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"><ssd:System name="two"><ssd:Elements>
<ssd:Component name="one" type="application/x-fmu-sharedlibrary" source="resources/one.fmu"/>
<ssd:Component name="other" type="application/x-fmu-sharedlibrary" source="resources/other.fmu"/>
</ssd:Elements></ssd:System></ssd:SystemStructureDescription>
"""


@FOREIGN
@pytest.mark.parametrize("importer", ["libcosim", "ecos"])
def test_two_gels_in_one_system_each_give_their_own_result(coarse_fmu, other_fmu, importer, tmp_path):
    ssp = tmp_path / "two.ssp"
    with zipfile.ZipFile(ssp, "w") as archive:
        archive.writestr("SystemStructure.ssd", SSD)
        archive.write(coarse_fmu, "resources/one.fmu")
        archive.write(other_fmu, "resources/other.fmu")
    expected = [alone(coarse_fmu, tmp_path / "a"), alone(other_fmu, tmp_path / "b")]
    watched = [(unit, "contact.total_impulse[3]") for unit in ("one", "other")]
    values = run_system.IMPORTERS[importer](ssp, STEP, STEPS * STEP, watched)
    assert values == pytest.approx(expected, rel=1e-12) and abs(values[0] - values[1]) > 0.01 * abs(values[0])


def first_step(folder):
    gel = Gel(str(folder))
    gel.start()
    gel.fmu.doStep(0.0, 1e-4)
    impulse = gel.get("contact.total_impulse").tolist()
    gel.free()
    return impulse


def test_a_tool_that_rewrites_the_description_and_adds_files_leaves_an_fmu_that_runs(coarse, tmp_path):
    folder = shutil.copytree(coarse, tmp_path / "rewritten")
    file = folder / "modelDescription.xml"
    tree = ElementTree.parse(file)
    tree.getroot().set("description", "rewritten by a tool")
    tree.write(file, encoding="utf-8", xml_declaration=True)
    (folder / "resources" / "tool").mkdir()
    (folder / "resources" / "tool" / "notes.txt").write_text("added by a tool")
    assert first_step(folder) == first_step(coarse)


def test_an_fmu_of_which_a_tool_removed_variables_runs(coarse_fmu, coarse, tmp_path):
    repacked = tmp_path / "repacked.fmu"
    with operations.FMU(coarse_fmu) as unpacked:
        unpacked.apply_operation(operations.OperationRemoveRegexp("fidelity|cost"))
        unpacked.repack(str(repacked))
    assert "fidelity" not in {v.name for v in read_model_description(str(repacked)).modelVariables}
    assert first_step(extract(str(repacked), str(tmp_path / "a"))) == first_step(coarse)


def edited(folder):
    scene = folder / "resources" / "scene.toml"
    scene.write_text(scene.read_text().replace("-5.0]", "-50.0]"))


def without_resources(folder):
    shutil.rmtree(folder / "resources")


def of_another(folder):
    text = (folder / "modelDescription.xml").read_text()
    own = guid(folder)
    (folder / "modelDescription.xml").write_text(text.replace(own, own[:-2] + ("0" if own[-2] != "0" else "1") + "}"))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (edited, "scene.toml: found content of hash"),
        (without_resources, "manifest.json: found no readable file"),
        (of_another, "fmuGUID = "),
    ],
)
def test_an_unpacked_archive_that_was_changed_is_refused_with_the_remedy(coarse, tmp_path, capfd, change, said):
    folder = Path(shutil.copytree(coarse, tmp_path / "changed"))
    change(folder)
    with pytest.raises(Exception, match="[Ii]nstantiate"):
        Gel(str(folder))
    sys.stdout.flush()
    log = "".join(capfd.readouterr())
    assert said in log and "pack the scene anew with gelfmu pack" in log
