"""`sphere-block` in DOLFINx: a residual in UFL, compiled and assembled in each step, with step and penalty in numpy.

Written for version 0.5, which Debian 12 has as python3-dolfinx. The first run compiles the form; later ones find it.
"""

import time

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import create_mesh
from mpi4py import MPI

import block

FAST = {"cffi_extra_compile_args": ["-O2", "-march=native"]}


def internal_force(space):
    """The displacement, and the form of the force inside: P = μ F + (λ ln J − μ) F⁻ᵀ against the gradient of the test."""
    displacement, test = fem.Function(space), ufl.TestFunction(space)
    f = ufl.Identity(3) + ufl.grad(displacement)
    stress = block.SHEAR * f + (block.LAMBDA * ufl.ln(ufl.det(f)) - block.SHEAR) * ufl.inv(f).T
    measure = ufl.dx(metadata={"quadrature_degree": 1})
    return displacement, fem.form(ufl.inner(stress, ufl.grad(test)) * measure, jit_params=FAST)


def numbers_in(space, mesh):
    """The number that DOLFINx gave to each node of the mesh: both sorted by their place on the grid."""
    grid = lambda points: np.rint((points - mesh.nodes.min(axis=0)) / block.CELL).astype(int)
    order = lambda points: np.lexsort(grid(points).T)
    numbers = np.empty(len(mesh.nodes), int)
    numbers[order(mesh.nodes)] = order(space.tabulate_dof_coordinates())
    return numbers


def run(mesh, gel, step, n_steps):
    """All steps of the symplectic Euler rule; the ball as it ends."""
    displacement, form = gel
    numbers = numbers_in(displacement.function_space, mesh)
    face, face_rest = numbers[mesh.face], mesh.nodes[mesh.face]
    inverse_mass = np.empty((len(numbers), 1))
    inverse_mass[numbers, 0] = mesh.inverse_masses()
    u, ball, stiffness = displacement.x.array.reshape(-1, 3), block.Ball(), mesh.penalties()
    velocity, force = np.zeros_like(u), np.zeros(u.size)
    for _ in range(n_steps):
        push, back = ball.push(face_rest + u[face], stiffness)
        force[:] = 0
        fem.assemble_vector(force, form)
        velocity -= step * inverse_mass * force.reshape(-1, 3)
        velocity[face] += step * inverse_mass[face] * push
        u += step * velocity
        ball.move(back, step)
    return ball


if __name__ == "__main__":
    chosen, steps = block.step_from_command_line(__doc__)
    grid = block.Mesh()
    shape = ufl.Mesh(ufl.VectorElement("Lagrange", "tetrahedron", 1))
    domain = create_mesh(MPI.COMM_WORLD, grid.tets.astype(np.int64), grid.nodes, shape)
    vectors = fem.VectorFunctionSpace(domain, ("Lagrange", 1))
    solid = internal_force(vectors)
    since = time.process_time()
    block.report("fenics-dolfinx", len(grid.tets), run(grid, solid, chosen, steps), since)
