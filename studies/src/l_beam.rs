use super::run::{Run, run, scene};
use ballistic_gel::simulation::Simulation;

/// Energy of `l-beam` over the run and through the impact, by schedule and contact law.
pub fn study() {
    println!(
        "| schedule | law | CFL | updates | loss in contact, % of E₀ | bias | greatest integration residual | at the end | closure |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for schedule in ["bins", "queue"] {
        for (law, cfl) in [("moreau", 0.8), ("moreau", 0.4), ("reversal", 0.8), ("reversal", 0.4), ("reversal", 0.1)] {
            row(schedule, law, cfl);
        }
    }
}

fn row(schedule: &str, law: &str, cfl: f64) {
    let keys = [
        ("integrator.schedule", schedule.to_owned()),
        ("integrator.cfl", cfl.to_string()),
        ("contact.law", law.to_owned()),
    ];
    let mut greatest: f64 = 0.0;
    let mut watch = |now: &Simulation| {
        let energy = now.observe().energy;
        greatest = greatest.max(energy.integration.abs() / energy.initial);
    };
    let Run { last, failure, .. } = run(&scene("l-beam", &keys), 300, &mut watch);
    assert!(failure.is_none(), "{failure:?}");
    let energy = &last.energy;
    println!(
        "| {schedule} | {law} | {cfl} | {:.2e} | {:+.3} | {:.1e} | {greatest:.1e} | {:+.1e} | {:.1e} |",
        last.cost.element_updates,
        100.0 * energy.contact / energy.initial,
        energy.contact_bias / energy.initial,
        energy.integration / energy.initial,
        energy.energy_error,
    );
}
