"""What the archive offers for wiring by hand."""

import os
import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy import read_model_description
from lxml import etree

SETS = ["integrated", "corrected", "full"]


@pytest.fixture(scope="module")
def archives():
    """`sphere-block` with each set of outputs, and with terminals."""
    folder = Path(os.environ["BALLISTIC_GEL_OUTPUT_SETS"])
    return {name: str(folder / f"{name}.fmu") for name in SETS}


def variables(fmu, causality):
    return {v.name for v in read_model_description(fmu).modelVariables if v.causality == causality}


def test_the_outputs_without_an_option_are_those_of_the_mode_and_few(fmu, archives):
    outputs = {name: variables(archive, "output") for name, archive in archives.items()}
    assert variables(fmu, "output") == outputs["integrated"]
    assert [len(outputs[name]) for name in SETS] == [16, 16, 46]
    assert {"projectile.predicted_velocity[3]", "contact.active"} <= outputs["integrated"]
    assert {"contact.impulse[3]", "projectile.predicted_orientation[4]"} <= outputs["corrected"]


def test_a_variable_has_its_reference_whether_it_is_an_output_or_not(archives):
    references = []
    for archive in archives.values():
        references.append({v.name: v.valueReference for v in read_model_description(archive).modelVariables})
    assert references[0] == references[1] == references[2]
    assert references[0]["contact.impulse[3]"] == 202


def test_texts_are_short_and_quantities_have_units_for_display_and_magnitudes(fmu):
    model = read_model_description(fmu)
    assert model.author == "The ballistic-gel authors" and len(model.description) < 100
    assert model.defaultExperiment.tolerance is not None
    assert all(len(v.description) < 100 for v in model.modelVariables)
    shown = {v.unit: v.displayUnit for v in model.modelVariables if v.displayUnit}
    assert shown == {"s": "ms", "m": "mm", "kg": "g", "Pa": "kPa"}
    assert all(float(v.nominal) > 0.0 for v in model.modelVariables if v.type == "Real")
    factors = {d.name: d.factor for unit in model.unitDefinitions for d in unit.displayUnits}
    assert factors == {"mm": 1e3, "ms": 1e3, "g": 1e3, "kPa": 1e-3}


def test_an_archive_has_terminals_only_when_asked_because_fmi_library_3_refuses_their_version(fmu, archives):
    def entries(file):
        with zipfile.ZipFile(file) as archive:
            return {name for name in archive.namelist() if name.startswith("terminalsAndIcons/")}

    assert entries(fmu) == set()
    assert entries(archives["full"]) == {"terminalsAndIcons/terminalsAndIcons.xml", "terminalsAndIcons/icon.png"}


def test_the_terminals_follow_the_schema_and_hold_every_port(fragments_fmu):
    with zipfile.ZipFile(fragments_fmu) as archive:
        names = archive.namelist()
        root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    etree.XMLSchema(etree.parse(schema)).assertValid(root)
    assert "terminalsAndIcons/icon.png" in names
    assert [t.get("name") for t in root.iter("Terminal")] == ["projectile", "fragment[1]", "fragment[2]"]
    members = [m.get("variableName") for m in root.iter("TerminalMemberVariable")]
    ports = variables(fragments_fmu, "input") | variables(fragments_fmu, "output")
    assert set(members) == ports and len(members) == len(set(members))


def test_the_cavity_belongs_to_no_terminal(archives):
    with zipfile.ZipFile(archives["full"]) as archive:
        root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    members = {m.get("variableName") for m in root.iter("TerminalMemberVariable")}
    assert variables(archives["full"], "output") - members == {"cavity.diameter", "cavity.depth"}


def test_a_dome_offers_its_bulge_and_nothing_that_would_move_it(fragments_fmu):
    inputs, outputs = variables(fragments_fmu, "input"), variables(fragments_fmu, "output")
    rates = ["bulge_height", "bulge_height_rate", "bulge_radius", "bulge_radius_rate"]
    assert sorted(name for name in inputs if name.startswith("fragment[2].")) == [
        f"fragment[2].{name}" for name in ["active", *rates]
    ]
    assert "fragment[2].contact.bulge_height_impulse" in outputs
    assert not any("bulge" in name for name in inputs if not name.startswith("fragment[2]."))


def test_choices_are_integers_that_every_importer_can_set(fmu):
    found = {v.name: v for v in read_model_description(fmu).modelVariables}
    assert not any(v.type == "Enumeration" for v in found.values())
    mode, level = found["coupling.mode"], found["fidelity"]
    assert (mode.type, mode.start, mode.min, mode.max) == ("Integer", "2", "1", "3")
    assert "3 corrected" in mode.description and "4 reference" in level.description
