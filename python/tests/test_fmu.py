"""FMUs: packed, run by fmpy, with the results of the command."""

import pytest

import ballistic_gel as bg

pytest.importorskip("fmpy")


@pytest.fixture(scope="module")
def fmu(quick, tmp_path_factory):
    values = {"output.frames": 0, "output.report": False}
    return bg.pack(quick.with_values(values), tmp_path_factory.mktemp("fmu") / "quick.fmu")


def test_the_fmu_gives_the_shot_of_the_command(fmu, quick, tmp_path):
    shot = bg.simulate(fmu, values={"projectile.initial_velocity[3]": -0.5}, out=tmp_path / "through fmpy")
    values = {"projectile.velocity[3]": -0.5}
    assert shot.digest == bg.run(quick, values=values, out=tmp_path / "c", frames=False, report=False).digest
    assert shot.folder.name == "through fmpy"


def test_the_caller_may_read_and_set_at_each_step(fmu, tmp_path):
    times = []

    def push(time, instance):
        times.append(time)
        instance.set({"projectile.external_force[3]": -100.0})

    pushed = bg.simulate(fmu, out=tmp_path / "p", on_step=push)
    assert len(times) == len(pushed.history) - 1
    assert pushed.digest != bg.simulate(fmu, out=tmp_path / "n").digest


def test_errors_of_the_fmu_name_the_variable(fmu, tmp_path):
    with pytest.raises(bg.GelfmuError, match="did you mean `projectile.mass`"):
        bg.simulate(fmu, values={"projectile.masss": 1.0}, out=tmp_path / "x")
    with pytest.raises(bg.GelfmuError) as refused:
        bg.simulate(fmu, values={"mesh.size": -1.0}, out=tmp_path / "x")
    assert refused.value.key == "mesh.size"
    assert refused.value.remedy == "expected at least 0 m"
    for name, value in (("mesh.size", "2 mm"), ("mesh.size", None), ("threads", "two"), ("scene", 5)):
        with pytest.raises(bg.GelfmuError, match=f"^{name}: found {value!r}, expected a (number|text)"):
            bg.simulate(fmu, values={name: value}, out=tmp_path / "x")


def test_a_run_that_stops_is_kept(tmp_path):
    scene = bg.Scene.built_in("ball-square").with_values({"output.frames": 0, "output.report": False})
    fmu = bg.pack(scene, tmp_path / "square.fmu")
    with pytest.raises(bg.ShotError, match="is inverted") as stopped:
        bg.simulate(fmu, out=tmp_path / "s")
    assert not stopped.value.shot.completed


def test_an_instance_is_reset(fmu, tmp_path):
    digests = []
    with bg.FmuInstance(fmu, "again") as instance:
        for velocity in (-1.0, -0.5, -1.0):
            instance.reset()
            instance.set({"output_directory": str(tmp_path), "projectile.initial_velocity[3]": velocity})
            instance.run()
            digests.append(bg.Shot.load(tmp_path / "again").digest)
    assert digests[0] == digests[2] != digests[1]
