//! The stack of the thread that calls: `docs/coupling.md` says how much it needs.

use super::host::Host;
use ballistic_gel::scene;

/// Bytes.
const STACK: usize = 96 << 10;

#[test]
fn a_thread_with_96_kib_of_stack_can_make_every_call_of_a_run() {
    let run = || {
        let mut host = Host::with(&text());
        let output = host.path("results");
        assert_eq!(host.set_text("output_directory", &output), 0);
        host.start();
        host.steps(0.0, 1e-4, 3);
        let bytes = host.bytes();
        host.steps(3e-4, 1e-4, 2);
        assert_eq!(host.restore(&bytes), 0);
        host.steps(3e-4, 1e-4, 2);
        assert!(host.integer("cost.remeshes") > 0);
    };
    std::thread::Builder::new().stack_size(STACK).spawn(run).unwrap().join().unwrap();
}

/// A planar scene whose mesh is remade on the way.
fn text() -> String {
    let changes = ["mesh.size=5e-3", "remesh.times=[1.5e-4, 3.5e-4]"].map(|change| change.parse().unwrap());
    scene::resolve(scene::builtin("ball-square").unwrap(), &changes).unwrap()
}
