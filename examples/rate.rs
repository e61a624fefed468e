use ballistic_gel::scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let sets: Vec<_> = args[3..].iter().map(|s| s.parse().unwrap()).collect();
    let text = scene::resolve(scene::builtin(&args[1]).unwrap(), &sets).unwrap();
    let scene = scene::read(&text).unwrap();
    let threads: usize = args[2].parse().unwrap();
    let t = std::time::Instant::now();
    let mut sim = Simulation::new(&scene, CouplingMode::Integrated, threads).unwrap();
    eprintln!("build {:.3}", t.elapsed().as_secs_f64());
    let inputs = sim.inputs();
    let t = std::time::Instant::now();
    sim.step(&inputs, 1e-9).unwrap();
    eprintln!("first tick {:.3}", t.elapsed().as_secs_f64());
    let t = std::time::Instant::now();
    let n = 10;
    let mut last = 0.0;
    for i in 1..=n {
        let a = std::time::Instant::now();
        sim.step(&inputs, scene.scene.end_time * f64::from(i) / f64::from(n)).unwrap();
        let o = sim.observe();
        eprintln!("{:.3} s: {:.1} M/s", a.elapsed().as_secs_f64(), (o.cost.element_updates - last) / a.elapsed().as_secs_f64() / 1e6);
        last = o.cost.element_updates;
    }
    let o = sim.observe();
    eprintln!("{:.3e} updates {:.3} s {:.1} M/s closure {:e} {:x}", o.cost.element_updates, t.elapsed().as_secs_f64(), o.cost.element_updates / t.elapsed().as_secs_f64() / 1e6, o.energy.energy_error, sim.digest());
}
