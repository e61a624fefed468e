"""What is in the archive."""

import os
import re
import zipfile
from pathlib import Path
from urllib.parse import unquote

from fmpy import read_model_description
from fmpy.validation import validate_fmu


def test_fmpy_finds_no_problem(fmu):
    assert validate_fmu(fmu) == []


def test_entries_are_sorted_and_carry_no_time(fmu):
    with zipfile.ZipFile(fmu) as archive:
        entries = archive.infolist()
    names = [e.filename for e in entries]
    assert names == sorted(names)
    assert {e.date_time for e in entries} == {(1980, 1, 1, 0, 0, 0)}
    assert {"modelDescription.xml", "model.png", "documentation/index.html", "resources/scene.toml"} <= set(names)
    assert any(name.startswith("binaries/") for name in names)
    assert "documentation/licenses/linked-crates.txt" in names


def test_the_default_experiment_is_that_of_the_scene(fmu):
    experiment = read_model_description(fmu).defaultExperiment
    assert [float(t) for t in (experiment.startTime, experiment.stopTime, experiment.stepSize)] == [0.0, 0.01, 1e-5]


def test_every_capability_is_declared(fmu):
    offered = read_model_description(fmu).coSimulation
    assert offered.canHandleVariableCommunicationStepSize and offered.canInterpolateInputs
    assert offered.canGetAndSetFMUstate and offered.canSerializeFMUstate and offered.providesDirectionalDerivative
    assert offered.maxOutputDerivativeOrder == 1 and not offered.canRunAsynchronuously


def test_nothing_feeds_through_but_the_carrier_of_the_derivative():
    full = str(Path(os.environ["BALLISTIC_GEL_OUTPUT_SETS"]) / "full.fmu")
    for unknown in read_model_description(full).outputs:
        inputs = {v.name.split("[")[0] for v in unknown.dependencies}
        carrier = unknown.variable.name.startswith("contact.linear_force")
        assert inputs == ({"projectile.position", "projectile.velocity"} if carrier else set())


def test_the_first_outputs_come_from_the_parameters_alone(fmu):
    unknowns = read_model_description(fmu).initialUnknowns
    assert {u.variable.causality for u in unknowns} == {"output", "calculatedParameter"}
    for unknown in unknowns:
        assert {v.causality for v in unknown.dependencies} == {"parameter"}
        names = {v.name for v in unknown.dependencies}
        assert {"scene", "coupling.mode", "gel.density", "projectile.initial_velocity[3]"} <= names
        assert not names & {"threads", "output_directory"}


def test_every_linked_package_is_named_and_the_index_leads_to_all_texts(fmu):
    folder = "documentation/licenses/"
    with zipfile.ZipFile(fmu) as archive:
        listed = archive.read(folder + "linked-crates.txt").decode().splitlines()[2:]
        page = archive.read(folder + "license.html").decode()
        texts = {n.removeprefix(folder): archive.read(n) for n in archive.namelist() if n.startswith(folder)}
    links = {unquote(link) for link in re.findall(r'href="([^"]+)"', page)}
    assert links == set(texts) - {"license.html", "linked-crates.txt"}
    packages = [line.split(": ")[0] for line in listed]
    assert re.findall(r"<li><b>([^<]+)</b>", page) == packages and len(packages) > 20
    assert packages[0].startswith("ballistic-gel-") and packages[-1].startswith("rust-standard-library-")
    assert "Permission is hereby granted" in page and "Apache License" in page
    # The archive of a development build holds the texts of this crate and of the standard library alone.
    is_development = read_model_description(fmu).generationTool.endswith("(development)")
    with_text = {link.split("/")[0] for link in links if len(texts[link]) > 500}
    assert with_text == ({packages[0], packages[-1]} if is_development else set(packages))


def test_the_layout_of_the_documentation_is_that_of_the_standard(fmu):
    with zipfile.ZipFile(fmu) as archive:
        names = archive.namelist()
        needs = archive.read("documentation/externalDependencies.html").decode()
        page = archive.read("documentation/index.html").decode()
    assert "documentation/licenses/license.html" in names and "External dependencies" in needs
    assert 'href="licenses/license.html"' in page and 'href="externalDependencies.html"' in page


def test_the_page_says_which_c_library_is_needed(fmu):
    with zipfile.ZipFile(fmu) as archive:
        page = archive.read("documentation/index.html").decode()
        libraries = [n for n in archive.namelist() if n.startswith("binaries/linux")]
        needed = b"GLIBC_" in b"".join(archive.read(n) for n in libraries)
    assert ("needs the GNU C library" in page) == needed
