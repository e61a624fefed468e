//! Studies that look into a run, each printed as a Markdown table: `cargo run --release --manifest-path studies/Cargo.toml -- NAME`.
//! Studies that need no more than the figures of runs are TOML files beside this package.

mod backface_dent;
mod ball_bounce;
mod behind_plate;
mod bounce_visco;
mod bullet_yaw;
mod cavity;
mod coupling;
mod cpu;
mod deepest;
mod elastic_gel;
mod extremes;
mod gain;
mod hydro_drag;
mod impacts;
mod l_beam;
mod leaks;
mod limits;
mod rest;
mod rheology;
mod run;
mod shot;
mod skin;
mod steps;
mod thousand;
mod touch;
mod whole;

#[path = "../../partners/src/plate.rs"]
mod plate;
#[allow(dead_code, reason = "it is shared with what packs the partners")]
#[path = "../../partners/src/table.rs"]
mod table;

type Study = (&'static str, &'static str, fn());

const STUDIES: [Study; 18] = [
    (
        "ball-bounce",
        "depth and restitution against the reference table, by mesh size and bulk modulus",
        ball_bounce::study,
    ),
    (
        "bounce-visco",
        "restitution of a viscoelastic gel against that of the elastic one times what viscosity leaves",
        bounce_visco::study,
    ),
    (
        "backface-dent",
        "pressure 50 and 100 mm deep, dent and viscous criterion, by body and mesh size",
        backface_dent::study,
    ),
    (
        "cavity",
        "cavity-exact: pressure against stretch, by shape and mesh size, with and without remeshing",
        cavity::study,
    ),
    ("coupling", "errors against the communication step, by how the importer moves the projectile", coupling::study),
    ("l-beam", "energy over the run, drop through impact, both schedules and both contact laws", l_beam::study),
    ("impacts", "conservation in offset, oblique and spinning impacts, and the first touch", impacts::study),
    ("leaks", "deepest penetration of nodes and faces, by shape and mesh size", leaks::study),
    ("gain", "updates and CPU seconds of the schedules on uniform, graded and sliver meshes", gain::study),
    (
        "deep-elastic",
        "sphere-deep about an axis: depth, rebound, energy and remade elements by speed and mesh size, slow force",
        elastic_gel::study,
    ),
    ("thousand", "ball-square with a thousand remeshings in a row, by both methods", thousand::study),
    ("rheology", "stress, modulus and loss angle of the gel of fbi-bb beside published ones", rheology::study),
    (
        "behind-plate",
        "fbi-bb behind a plate that it perforates, against shots at the speed that is left",
        behind_plate::study,
    ),
    (
        "bullet-yaw",
        "a rigid bullet by the yaw with which it comes: yaw by depth, neck, law of the cosh",
        bullet_yaw::study,
    ),
    ("skin", "perforation thresholds of skin as a layer, one of them fitted", skin::study),
    ("steps", "a hundred shots over the range of gels and speeds: whether asynchronous steps diverge", steps::study),
    ("hydro-drag", "drag and slam of a ball in a fluid, by mesh size and grading", hydro_drag::study),
    ("extremes", "every limit against what is known beforehand; masses, speeds, a second of rest", extremes::study),
];

fn main() -> std::process::ExitCode {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let known = |name: &String| name == "all" || STUDIES.iter().any(|study| study.0 == name);
    if asked.is_empty() || !asked.iter().all(known) {
        eprintln!("usage: studies NAME..., where NAME is `all` or one of");
        for (name, about, _) in STUDIES {
            eprintln!("  {name:14} {about}");
        }
        return std::process::ExitCode::from(2);
    }
    for (name, about, study) in STUDIES {
        if asked.iter().any(|a| a == name || a == "all") {
            println!("### {name}: {about}\n");
            study();
            println!();
        }
    }
    std::process::ExitCode::SUCCESS
}
