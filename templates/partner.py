"""Template of a partner in Python: a rigid body that meets the gel in a loop of your own.

    pip install fmpy
    cargo run --release --manifest-path partners/Cargo.toml -- gelfmu-out/systems
    python templates/partner.py gelfmu-out/systems/gel-and-body-corrected.ssp

`RigidBody` has the ports of `RigidBody.fmu`, and takes its place in the loop of examples/run_system.py. Its step
is the update of docs/coupling.md, section 3, which any model that owns the body has to make. To build your own, change
`own_wrench`: the force and torque that act on the body beside the gel, constant over the step. As an FMU:
templates/partner_fmu.py.
"""

import sys
from pathlib import Path

import numpy as np

# Name and number of components of each variable, by its causality.
PARAMETERS = {
    "mass": 1,
    "inertia": 6,
    "initial_position": 3,
    "initial_velocity": 3,
    "initial_orientation": 4,
    "initial_angular_velocity": 3,
}
INPUTS = {"impulse": 3, "angular_impulse": 3, "impulse_moment": 3, "predicted_orientation": 4, "force": 3, "torque": 3}
OUTPUTS = {"position": 3, "velocity": 3, "orientation": 4, "angular_velocity": 3, "total_impulse": 3}


def scalars(sizes):
    """Variable and component of each scalar, by its name in the FMU."""
    return {
        name if size == 1 else f"{name}[{i + 1}]": (name, i) for name, size in sizes.items() for i in range(size)
    }


def rotation(q):
    """Matrix of a unit quaternion (w, x, y, z)."""
    w, (x, y, z) = q[0], q[1:]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross


def product(p, q):
    """Hamilton product of two quaternions."""
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


class RigidBody:
    """A rigid body that owns its state. It has the methods of a unit of `run_system.Loop`."""

    def __init__(self, starts):
        """Start values of parameters by their names in the FMU, such as `initial_position[3]`."""
        self.variables = scalars({**PARAMETERS, **INPUTS, **OUTPUTS})
        self.starts = dict(starts)

    @classmethod
    def of_fmu(cls, file):
        """The body with the start values of a packed RigidBody.fmu."""
        from fmpy import read_model_description

        variables = read_model_description(str(file)).modelVariables
        return cls({v.name: float(v.start) for v in variables if v.causality == "parameter"})

    def own_wrench(self, time):
        """Your force, N, and torque about the centre of mass, N.m, on the body in the step that begins at a time."""
        return self.values["force"], self.values["torque"]

    def instantiate(self):
        self.values = {name: np.zeros(size) for name, size in {**PARAMETERS, **INPUTS, **OUTPUTS}.items()}
        for name, value in self.starts.items():
            self.set(name, value)

    def initialise(self):
        v = self.values
        for name in ("position", "velocity", "orientation"):
            v[name] = v[f"initial_{name}"].copy()
        xx, yy, zz, xy, xz, yz = v["inertia"]
        self.inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        turn = rotation(v["orientation"])
        self.angular_momentum = turn @ self.inertia @ turn.T @ v["initial_angular_velocity"]
        self.turn(v["orientation"])

    def get(self, name):
        variable, i = self.variables[name]
        return float(self.values[variable][i])

    def set(self, name, value):
        variable, i = self.variables[name]
        self.values[variable][i] = value

    def step(self, time, step):
        """Moves the body by its own force and torque and by what the gel gave back over the step."""
        v, (force, torque), mass = self.values, self.own_wrench(time), self.values["mass"][0]
        v["position"] += v["velocity"] * step + (force * step**2 / 2 + v["impulse_moment"]) / mass
        v["velocity"] += (force * step + v["impulse"]) / mass
        v["total_impulse"] += v["impulse"]
        self.angular_momentum += torque * step + v["angular_impulse"]
        predicted = v["predicted_orientation"]
        self.turn(predicted.copy() if predicted.any() else self.turned_on(step))

    def turned_on(self, step):
        """Orientation after a step with the present angular velocity: of first order, where the gel predicts none."""
        spin = self.values["angular_velocity"] * step
        angle = np.linalg.norm(spin)
        half = np.array([np.cos(angle / 2), *(spin / 2 * np.sinc(angle / 2 / np.pi))])
        return product(half, self.values["orientation"])

    def turn(self, orientation):
        """Sets the orientation, and the angular velocity that goes with it and with the angular momentum."""
        turn = rotation(orientation / np.linalg.norm(orientation))
        self.values["orientation"] = orientation
        self.values["angular_velocity"] = turn @ np.linalg.solve(self.inertia, turn.T @ self.angular_momentum)

    def free(self):
        """There is nothing to free."""


def main(arguments):
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))
    from run_system import System, with_sequential_loop

    ssp = Path(arguments[0])
    step, stop = [float(text) for text in arguments[1:3]] or (1e-5, 1e-2)
    body = RigidBody.of_fmu(ssp.parent / Path(System(ssp).files["body"]).name)
    values = with_sequential_loop(ssp, step, stop, partners={"body": body})
    for at, value in zip(System(ssp).shown(), values, strict=True):
        print(f"{'.'.join(at)} = {value!r}")


if __name__ == "__main__":
    main(sys.argv[1:])
