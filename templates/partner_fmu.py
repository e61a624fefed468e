"""Template of a partner as an FMU written in Python: `RigidBody` of partner.py with the ports of RigidBody.fmu.

    pip install pythonfmu numpy fmpy
    pythonfmu build -f templates/partner_fmu.py templates/partner.py

The FMU needs Python with numpy in the process of the importer. Importers in Python have it: fmpy, and the loop of
examples/run_system.py. Start values are parameters; those below are the ball of the gel's scene `sphere-block`.
"""

from partner import INPUTS, OUTPUTS, PARAMETERS, RigidBody, scalars
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

STARTS = {
    "mass": 0.033,
    "inertia[1]": 1.32e-6,
    "inertia[2]": 1.32e-6,
    "inertia[3]": 1.32e-6,
    "initial_position[3]": 0.010,
    "initial_velocity[3]": -5.0,
    "initial_orientation[1]": 1.0,
}
KINDS = [
    (PARAMETERS, Fmi2Causality.parameter, Fmi2Variability.fixed),
    (INPUTS, Fmi2Causality.input, Fmi2Variability.continuous),
    (OUTPUTS, Fmi2Causality.output, Fmi2Variability.discrete),
]


class PythonBody(Fmi2Slave):
    """The FMU around one body."""

    description = "A rigid body in Python that owns its state and is moved by impulses"

    def __init__(self, **options):
        super().__init__(**options)
        self.body = RigidBody(STARTS)
        self.body.instantiate()
        for sizes, causality, variability in KINDS:
            for name in scalars(sizes):
                self.register_variable(self.port(name, causality, variability))

    def port(self, name, causality, variability):
        """A scalar of the body as a variable of the FMU."""
        return Real(
            name,
            causality=causality,
            variability=variability,
            getter=lambda: self.body.get(name),
            setter=lambda value: self.body.set(name, value),
        )

    def exit_initialization_mode(self):
        self.body.initialise()

    def do_step(self, current_time, step_size):
        self.body.step(current_time, step_size)
        return True
