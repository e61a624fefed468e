"""`sphere-block` in Kratos: its total Lagrangian tetrahedra and central differences, the penalty from numpy as loads."""

import time

import KratosMultiphysics as Kratos
import KratosMultiphysics.ConstitutiveLawsApplication as laws
import KratosMultiphysics.StructuralMechanicsApplication as structural
import numpy as np

import block

VECTORS = [
    Kratos.DISPLACEMENT, Kratos.VELOCITY, Kratos.ACCELERATION, Kratos.REACTION, Kratos.VOLUME_ACCELERATION,
    structural.MIDDLE_VELOCITY, Kratos.NODAL_MASS, Kratos.FORCE_RESIDUAL, Kratos.RESIDUAL_VECTOR, structural.POINT_LOAD,
]  # fmt: skip


def part_of(model):
    """An empty model part with the variables that the explicit scheme wants, and no damping."""
    part = model.CreateModelPart("gel", 2)
    for variable in VECTORS:
        part.AddNodalSolutionStepVariable(variable)
    part.ProcessInfo[Kratos.DOMAIN_SIZE] = 3
    part.ProcessInfo[Kratos.COMPUTE_LUMPED_MASS_MATRIX] = True
    part.ProcessInfo[structural.RAYLEIGH_ALPHA] = part.ProcessInfo[structural.RAYLEIGH_BETA] = 0.0
    return part


def material_of(part):
    """The neo-Hookean gel: ν = λ/(2 (λ + μ)), E = 2 μ (1 + ν)."""
    twice_poisson = block.LAMBDA / (block.LAMBDA + block.SHEAR)
    properties = part.CreateNewProperties(1)
    properties[Kratos.DENSITY] = block.DENSITY
    properties[Kratos.YOUNG_MODULUS] = block.SHEAR * (2 + twice_poisson)
    properties[Kratos.POISSON_RATIO] = twice_poisson / 2
    properties[Kratos.CONSTITUTIVE_LAW] = laws.HyperElastic3DLaw().Clone()
    return properties


def fill(part, mesh):
    """Nodes, elements, and a point load at each node of the face; the part of the loaded nodes. Numbers start at 1."""
    material = material_of(part)
    for i, place in enumerate(mesh.nodes.tolist(), 1):
        part.CreateNewNode(i, *place)
    for i, nodes in enumerate((mesh.tets + 1).tolist(), 1):
        part.CreateNewElement("TotalLagrangianElement3D4N", i, nodes, material)
    face = part.CreateSubModelPart("face")
    face.AddNodes((mesh.face + 1).tolist())
    for i, node in enumerate((mesh.face + 1).tolist(), 1):
        part.CreateNewCondition("PointLoadCondition3D1N", i, [node], material)
    return face


def hold(part, fixed):
    """Degrees of freedom at every node, and none where the block is held."""
    axes = [Kratos.DISPLACEMENT_X, Kratos.DISPLACEMENT_Y, Kratos.DISPLACEMENT_Z]
    reactions = [Kratos.REACTION_X, Kratos.REACTION_Y, Kratos.REACTION_Z]
    for axis, reaction in zip(axes, reactions):
        Kratos.VariableUtils().AddDof(axis, reaction, part)
    for node in (fixed + 1).tolist():
        for axis in axes:
            part.GetNode(node).Fix(axis)


def strategy_of(part, step):
    """The explicit strategy, ready to step."""
    scheme = structural.ExplicitCentralDifferencesScheme(1.0, 0.333, 0.0)  # what a fixed step does not use
    strategy = structural.MechanicalExplicitStrategy(part, scheme, False, False, True)
    strategy.SetRebuildLevel(0)
    part.SetBufferSize(2)
    part.ProcessInfo[Kratos.DELTA_TIME] = step
    strategy.Check()
    strategy.Initialize()
    return strategy


def run(part, face, strategy, stiffness, n_steps):
    """All steps; the ball as it ends."""
    ball, access, step = block.Ball(), Kratos.VariableUtils(), part.ProcessInfo[Kratos.DELTA_TIME]
    for n in range(1, n_steps + 1):
        part.CloneTimeStep(n * step)
        part.ProcessInfo[Kratos.STEP] = n
        points = np.array(access.GetCurrentPositionsVector(face.Nodes, 3)).reshape(-1, 3)
        push, back = ball.push(points, stiffness)
        access.SetSolutionStepValuesVector(face.Nodes, structural.POINT_LOAD, Kratos.Vector(push.ravel()), 0)
        strategy.InitializeSolutionStep()
        strategy.Predict()
        strategy.SolveSolutionStep()
        strategy.FinalizeSolutionStep()
        ball.move(back, step)
    return ball


if __name__ == "__main__":
    chosen, steps = block.step_from_command_line(__doc__)
    Kratos.ParallelUtilities.SetNumThreads(1)
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    gel, whole = block.Mesh(), Kratos.Model()  # a part lives as long as its model
    solid = part_of(whole)
    struck = fill(solid, gel)
    hold(solid, gel.fixed)
    explicit = strategy_of(solid, chosen)
    since = time.process_time()
    end = run(solid, struck, explicit, gel.penalties(), steps)
    block.report("KratosMultiphysics", len(gel.tets), end, since)
