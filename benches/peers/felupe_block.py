"""`sphere-block` in felupe: its internal force (numpy and einsum), with step and penalty written in numpy."""

import time

import felupe
import numpy as np

import block


def solid_of(mesh):
    """The gel as a solid body of linear tetrahedra."""
    region = felupe.RegionTetra(felupe.Mesh(mesh.nodes, mesh.tets, "tetra"))
    field = felupe.FieldContainer([felupe.Field(region, dim=3)])
    return felupe.SolidBody(felupe.NeoHookeCompressible(mu=block.SHEAR, lmbda=block.LAMBDA), field)


def run(mesh, step, n_steps):
    """All steps of the symplectic Euler rule; the ball as it ends."""
    solid, ball, stiffness = solid_of(mesh), block.Ball(), mesh.penalties()
    displacement = solid.field[0].values
    velocity, inverse_mass = np.zeros_like(displacement), mesh.inverse_masses()[:, None]
    for _ in range(n_steps):
        push, back = ball.push(mesh.nodes[mesh.face] + displacement[mesh.face], stiffness)
        force = -np.asarray(solid.assemble.vector(solid.field).todense()).reshape(-1, 3)
        force[mesh.face] += push
        velocity += step * inverse_mass * force
        displacement += step * velocity
        ball.move(back, step)
    return ball


if __name__ == "__main__":
    chosen, steps = block.step_from_command_line(__doc__)
    gel = block.Mesh()
    since = time.process_time()
    block.report("felupe", len(gel.tets), run(gel, chosen, steps), since)
