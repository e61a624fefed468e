//! A gel in space that is turned as a whole: the same motion, turned.

use super::{Case, MOREAU, ball, block, gel_on, in_space, patches, run};
use ballistic_gel::contact::{BodyState, FreeDirections};
use ballistic_gel::fem::{Potential, Simplices};
use ballistic_gel::integrator::{Engine, IntegratorSettings};
use ballistic_gel::math::Vector3;
use ballistic_gel::mesh::Mesh;
use nalgebra::Rotation3;

/// The case in space with all of it turned: the mesh, which is not made again, the ball and its velocity.
fn turned(case: Case, turn: &Rotation3<f64>) -> Engine<3, Simplices<3>> {
    let mesh = block::<3>(case);
    let patches = patches(case, &mesh);
    let rest = mesh.rest.iter().map(|x| turn * x).collect();
    let gel = gel_on(&Mesh { rest, ..mesh }, patches, case);
    let nodes = gel.potential.rest().iter().map(|x| (*x, Vector3::zeros())).collect();
    let (body, state) = ball(FreeDirections::SPATIAL, 0.0);
    let state = BodyState { position: turn * state.position, velocity: turn * state.velocity, ..state };
    let rules = IntegratorSettings { schedule: case.schedule, cfl: 0.8, law: MOREAU, force_window: 1.0, damping: 0.0 };
    Engine::new(gel, vec![(body, state)], rules, nodes)
}

#[test]
fn a_turned_mesh_does_what_the_mesh_does() {
    let turn = Rotation3::new(Vector3::new(0.7, -1.1, 0.4));
    for case in in_space() {
        let [plain, other] = [Rotation3::identity(), turn].map(|turn| run(turned(case, &turn), 0.5));
        assert!(plain.bodies[0].velocity.z > -0.19, "{case:?}: the ball has met the gel");
        let far = |a: &Vector3, b: &Vector3| (turn * a - b).norm();
        let pairs = plain.position.iter().zip(&other.position).chain(plain.velocity.iter().zip(&other.velocity));
        let [a, b] = [&plain, &other].map(|state| state.bodies[0]);
        let off = pairs.map(|(a, b)| far(a, b)).fold(far(&a.velocity, &b.velocity), f64::max);
        assert!(off < 1e-10, "{case:?}: {off:e}");
        let [a, b] = [&plain, &other].map(|state| state.ledger.energy);
        let accounts = [a.contact - b.contact, a.viscous - b.viscous, a.damage - b.damage, a.friction - b.friction];
        assert!(accounts.iter().all(|off| off.abs() < 1e-11), "{case:?}: {accounts:?}");
        let frame = turn.matrix();
        for (own, other) in plain.memory.iter().zip(&other.memory) {
            let off = (frame * own.inverse * frame.transpose() - other.inverse).norm();
            let off = off + (own.damage - other.damage).abs() + (own.stress - other.stress).abs();
            assert!(off < 1e-9, "{case:?}: {off:e} of {own:?}");
        }
    }
}
