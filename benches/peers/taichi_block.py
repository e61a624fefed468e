"""`sphere-block` in Taichi: kernels as a user of that language writes them, forces scattered with atomic additions.

The CPU seconds of the stepping do not hold the compilation of the kernels, those of the whole process do. Taichi keeps
compiled kernels for later runs.
"""

import time

import numpy as np
import taichi as ti

import block

ti.init(arch=ti.cpu, cpu_max_num_threads=1, default_fp=ti.f64, fast_math=False, log_level=ti.ERROR)


@ti.data_oriented
class Impact:
    """Gel and ball as fields; a step is `forces`, `contact`, `move`, `move_ball`."""

    def __init__(self, mesh, step):
        self.step = step
        inverse = np.linalg.inv(mesh.edges().transpose(0, 2, 1))
        self.tets = field(mesh.tets.astype(np.int32), ti.i32)
        self.inverse, self.volume = matrices(inverse), field(mesh.volumes())
        self.x, self.inverse_mass = vectors(mesh.nodes), field(mesh.inverse_masses())
        self.v, self.f = vectors(0 * mesh.nodes), vectors(0 * mesh.nodes)
        self.face, self.stiffness = field(mesh.face.astype(np.int32), ti.i32), field(mesh.penalties())
        self.ball_x, self.ball_v, self.ball_f = (ti.Vector.field(3, ti.f64, ()) for _ in range(3))
        self.deepest = ti.Vector.field(2, ti.f64, ())  # depth, m, and its time, s
        self.ball_x[None], self.ball_v[None] = block.BODY["position"], block.BODY["velocity"]

    @ti.kernel
    def forces(self):
        """−V P Dm⁻ᵀ on three nodes of each tetrahedron, minus their sum on the first; P = μ F + (λ ln J − μ) F⁻ᵀ."""
        for e in self.volume:
            a, b, c, d = self.tets[e, 0], self.tets[e, 1], self.tets[e, 2], self.tets[e, 3]
            origin = self.x[a]
            edges = ti.Matrix.cols([self.x[b] - origin, self.x[c] - origin, self.x[d] - origin])
            f = edges @ self.inverse[e]
            pressure = block.LAMBDA * ti.log(f.determinant()) - block.SHEAR
            stress = block.SHEAR * f + pressure * f.inverse().transpose()
            force = -self.volume[e] * stress @ self.inverse[e].transpose()
            on_b = ti.Vector([force[0, 0], force[1, 0], force[2, 0]])
            on_c = ti.Vector([force[0, 1], force[1, 1], force[2, 1]])
            on_d = ti.Vector([force[0, 2], force[1, 2], force[2, 2]])
            self.f[b] += on_b
            self.f[c] += on_c
            self.f[d] += on_d
            self.f[a] -= on_b + on_c + on_d

    @ti.kernel
    def contact(self):
        """The penalty of `block.Ball.push`."""
        for k in self.face:
            away = self.x[self.face[k]] - self.ball_x[None]
            distance = away.norm()
            if distance < block.RADIUS:
                push = self.stiffness[k] * (block.RADIUS - distance) / distance * away
                self.f[self.face[k]] += push
                self.ball_f[None] -= push

    @ti.kernel
    def move(self):
        """Kick and drift every node."""
        for i in self.x:
            self.v[i] += self.step * self.inverse_mass[i] * self.f[i]
            self.x[i] += self.step * self.v[i]
            self.f[i] = ti.Vector([0.0, 0.0, 0.0])

    @ti.kernel
    def move_ball(self, time: ti.f64):
        """Kick and drift the ball, and remember where it was deepest."""
        self.ball_v[None] += self.step / block.MASS * self.ball_f[None]
        self.ball_x[None] += self.step * self.ball_v[None]
        self.ball_f[None] = ti.Vector([0.0, 0.0, 0.0])
        depth = block.RADIUS - self.ball_x[None][2]
        if depth > self.deepest[None][0]:
            self.deepest[None] = ti.Vector([depth, time])

    def advance(self, n):
        """Step `n`, the first one being 1."""
        self.forces()
        self.contact()
        self.move()
        self.move_ball(n * self.step)

    def ball(self):
        """The ball as it is now."""
        ball = block.Ball()
        ball.depth, ball.deepest_at = self.deepest[None].to_numpy().tolist()
        ball.velocity = self.ball_v[None].to_numpy()
        return ball


def field(values, kind=ti.f64):
    """A field of numbers with these values."""
    made = ti.field(kind, values.shape)
    made.from_numpy(values)
    return made


def vectors(values):
    """A field of vectors with these values."""
    made = ti.Vector.field(3, ti.f64, len(values))
    made.from_numpy(values)
    return made


def matrices(values):
    """A field of matrices with these values."""
    made = ti.Matrix.field(3, 3, ti.f64, len(values))
    made.from_numpy(values)
    return made


if __name__ == "__main__":
    chosen, steps = block.step_from_command_line(__doc__)
    gel = block.Mesh()
    impact = Impact(gel, chosen)
    impact.advance(1)  # compiles
    since = time.process_time()
    for step in range(2, steps + 1):
        impact.advance(step)
    ti.sync()
    block.report("taichi", len(gel.tets), impact.ball(), since)
