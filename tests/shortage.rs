//! Shortages of memory: what an importer is told instead of being killed.
//!
//! A preloaded allocator refuses one request of a run, or from one request on all that would add to what is held. The long form,
//! with every site of a request: `cargo test --release --test shortage -- --ignored --nocapture every_site`.
#![allow(unsafe_code)] // the interface is one of pointers
#![allow(clippy::unwrap_used)] // a test that cannot go on fails

#[path = "shortage/campaign.rs"]
mod campaign;
#[path = "shortage/driven.rs"]
mod driven;
#[path = "shortage/shim.rs"]
mod shim;

use ballistic_gel::fmi2::AmountOfMemory;
use ballistic_gel::scene;
use ballistic_gel::simulation::{CouplingMode, Simulation, memory_estimate};
use campaign::{Outcome, Profile, Refusal, Stage};
use driven::{Driven, Ending};
use std::path::Path;

/// Requests above this are told of.
const LARGE: u64 = 64 << 10;

/// A planar scene of 1600 elements whose mesh is remade in the second step, and again in a later one.
fn planar() -> String {
    planar_of("5e-3")
}

fn planar_of(size: &str) -> String {
    let size = format!("mesh.size={size}");
    changed("ball-square", &[&size, "remesh.times=[1.5e-4, 3.5e-4]", "scene.end_time=1e-3", "output.frames=3"])
}

/// A spatial scene whose mesh is remade in the second step.
fn spatial(size: &str) -> String {
    let size = format!("mesh.size={size}");
    changed("sphere-block", &[&size, "remesh.times=[1.5e-4, 3.5e-4]", "scene.end_time=1e-3", "output.frames=3"])
}

fn changed(name: &str, changes: &[&str]) -> String {
    let changes: Vec<_> = changes.iter().map(|change| change.parse().unwrap()).collect();
    scene::resolve(scene::builtin(name).unwrap(), &changes).unwrap()
}

/// Run as a process of its own by [`Stage`], with the shim in front of its allocator.
#[test]
#[ignore = "driven by the other tests"]
fn the_driven_importer() {
    let Some(shim) = shim::Shim::preloaded() else { return };
    let [plan, scene, results] =
        ["PLAN", "SCENE", "RESULTS"].map(|name| std::env::var(format!("GEL_SHORTAGE_{name}")).unwrap());
    let (kind, what) = plan.split_once(' ').unwrap_or((&plan, ""));
    let mut importer = Driven::new(&shim);
    match kind {
        "profile" => shim.profile(Path::new(what)),
        "limit" | "once" => shim.plan(what.parse().unwrap(), kind == "limit"),
        "space" | "beyond" => shim::limit_space(Some(what.parse().unwrap())),
        _ => {}
    }
    if kind == "beyond" {
        return println!("ENDING refused {}", importer.refusal(Path::new(&scene)));
    }
    let ending = importer.run(Path::new(&scene), &results);
    if kind == "profile" {
        shim.end_profile();
    }
    for (name, bytes) in &importer.spent {
        println!("SPENT {name} {bytes}");
    }
    println!("{} requests, {} refused", shim.requests(), shim.refused());
    match ending {
        Ending::Completed => println!("ENDING completed"),
        Ending::Refused(words) => println!("ENDING refused {words}"),
    }
}

/// Outcomes that are no answer.
fn is_an_end(outcome: &Outcome) -> bool {
    matches!(outcome, Outcome::Aborted(_) | Outcome::Crashed(_))
}

/// Bytes of the least reserve, which is held beside what a phase takes.
const LEAST_RESERVE: u64 = (32 << 20) + 4096;

#[test]
fn no_phase_takes_more_memory_than_it_reserves_and_building_and_remeshing_half_of_it() {
    for text in [planar_of("1.25e-3"), spatial("4e-3")] {
        let Some(stage) = Stage::new(&text, false) else { return };
        let scene = scene::read(&text).unwrap();
        let (estimate, spent) = (memory_estimate(&scene).unwrap(), stage.spent());
        let most = |name: &str| spent.iter().filter(|call| call.0 == name).map(|call| call.1).max().unwrap();
        let simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        let restoring = simulation.memory_of_restoring(&simulation.save());
        for (call, reserved, least) in [
            ("fmi2ExitInitializationMode", estimate.building, estimate.building / 2),
            ("fmi2DoStep", estimate.remeshing, estimate.remeshing / 2),
            ("fmi2GetFMUstate", simulation.memory_of_state(), 0),
            ("fmi2SetFMUstate", restoring, 0),
        ] {
            let spent = most(call) - reserved.max(LEAST_RESERVE);
            println!("{}: {call}: {spent} of {reserved} bytes", scene.scene.name);
            assert!(spent <= reserved + 100_000, "{call} took {spent} bytes and had {reserved}");
            assert!(spent >= least, "{call} took {spent} bytes of {reserved}");
        }
    }
}

#[test]
fn a_refused_request_for_memory_is_made_good_or_told_in_words() {
    for (text, n) in [(planar(), 30), (spatial("10e-3"), 8)] {
        let Some(stage) = Stage::new(&text, false) else { return };
        let profile = stage.profile();
        let sites: Vec<Vec<i64>> = profile.sites().into_values().collect();
        let some = sites.iter().step_by((sites.len() / n).max(1));
        let refusals: Vec<Refusal> = some.flat_map(|numbers| ends(numbers)).chain(random(&profile, n)).collect();
        let outcomes = stage.outcomes(&refusals);
        let ended: Vec<_> = outcomes.iter().filter(|(_, outcome)| is_an_end(outcome)).collect();
        assert!(ended.is_empty(), "{} of {}: {ended:?}", ended.len(), outcomes.len());
        let refused = outcomes.iter().filter(|(_, outcome)| matches!(outcome, Outcome::Refused(_))).count();
        println!("{} sites, {} runs, {refused} refused", sites.len(), outcomes.len());
    }
}

#[test]
fn a_limit_of_the_address_space_is_met_in_words() {
    const MB: u64 = 1_000_000;
    let Some(stage) = Stage::new(&spatial("4e-3"), false) else { return };
    let mut refused = vec![];
    for bytes in [0, 5, 30, 45, 70, 100, 150] {
        match stage.outcome_in_space(bytes * MB) {
            Outcome::Completed => {}
            Outcome::Refused(words) => refused.push(words),
            ended => panic!("{bytes} MB: {ended:?}"),
        }
    }
    assert!(refused.len() > 3, "{refused:#?}");
    assert!(refused.iter().all(|words| words.contains("memory: ")), "{refused:#?}");
}

#[test]
fn a_scene_that_is_larger_than_the_memory_is_refused_with_both_figures() {
    let text = changed("sphere-block", &["mesh.size=1e-3"]);
    let Some(stage) = Stage::new(&text, false) else { return };
    let words = stage.refusal_in_space(1_000_000_000);
    let needed = AmountOfMemory(memory_estimate(&scene::read(&text).unwrap()).unwrap().building);
    let needs = format!("building the scene needs about {needed}");
    assert!(words.contains(&needs) && words.contains("raise mesh.size"), "{words}");
    assert!(words.contains(" MB of the address space of the process (RLIMIT_AS) are available"), "{words}");
}

/// The first and the last of the requests of a site, each as a limit, and the middle one once.
fn ends(numbers: &[i64]) -> Vec<Refusal> {
    let limit = |request: &i64| Refusal { request: *request, is_limit: true };
    let once = Refusal { request: numbers[numbers.len() / 2], is_limit: false };
    let mut chosen: Vec<_> = numbers.first().into_iter().chain(numbers.last()).map(limit).collect();
    chosen.dedup();
    chosen.push(once);
    chosen
}

/// So many requests, each as a limit, by a generator with a fixed seed.
fn random(profile: &Profile, n: usize) -> impl Iterator<Item = Refusal> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let all = profile.requests.len() as u64;
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        Refusal { request: ((state >> 33) % all).cast_signed(), is_limit: true }
    })
    .take(n)
}

/// The long form: each site of a request, or with GEL_SHORTAGE_STRIDE=n each n-th, and 500 requests at random, or their n-th part.
#[test]
#[ignore = "takes minutes: cargo test --release --test shortage -- --ignored --nocapture every_site"]
fn every_site_of_a_request_for_memory() {
    let stride = std::env::var("GEL_SHORTAGE_STRIDE").map_or(1, |n| n.parse().unwrap());
    for (name, text, writes) in
        [("planar", planar(), false), ("spatial", spatial("10e-3"), false), ("planar, with results", planar(), true)]
    {
        let Some(stage) = Stage::new(&text, writes) else { return };
        let profile = stage.profile();
        let sites = profile.sites();
        let some = sites.values().step_by(stride);
        let refusals: Vec<Refusal> =
            some.flat_map(|numbers| ends(numbers)).chain(random(&profile, 500 / stride)).collect();
        println!("{name}: {} runs at each {stride}-th of {} sites", refusals.len(), sites.len());
        let outcomes = stage.outcomes(&refusals);
        report(name, (&profile, &outcomes));
    }
}

/// Prints how many runs ended how, and the sites at which any ended the process.
fn report(name: &str, (profile, outcomes): (&Profile, &[(Refusal, Outcome)])) {
    let large = profile.requests.iter().filter(|request| request.bytes > LARGE);
    let large: std::collections::BTreeSet<u64> = large.map(|request| request.site).collect();
    let count = |is_it: fn(&Outcome) -> bool| outcomes.iter().filter(|(_, outcome)| is_it(outcome)).count();
    println!(
        "{name}: {} requests at {} sites, {} of them above 64 KiB; {} runs: {} completed, {} refused in words, {} aborted, {} crashed",
        profile.requests.len(),
        profile.frames.len(),
        large.len(),
        outcomes.len(),
        count(|outcome| *outcome == Outcome::Completed),
        count(|outcome| matches!(outcome, Outcome::Refused(_))),
        count(|outcome| matches!(outcome, Outcome::Aborted(_))),
        count(|outcome| matches!(outcome, Outcome::Crashed(_))),
    );
    for (refusal, outcome) in outcomes.iter().filter(|(_, outcome)| is_an_end(outcome)) {
        let request = profile.requests[refusal.request as usize];
        println!("  {refusal:?}, {} bytes in {}: {outcome:?}", request.bytes, profile.name(request.site));
    }
    println!("  largest requests, bytes:");
    for (site, bytes) in profile.largest().into_iter().take(25) {
        println!("  {bytes:>10} {}", profile.name(site));
    }
}

#[test]
fn elements_are_estimated_before_there_is_a_mesh() {
    let changes: [(&str, &[&str]); 8] = [
        ("ball-square", &["mesh.size=5e-3"]),
        ("ball-square", &["mesh.size=5e-3", "mesh.lattice=kuhn"]),
        ("sphere-block", &["mesh.size=10e-3"]),
        ("sphere-block", &["mesh.size=10e-3", "mesh.lattice=kuhn"]),
        ("fbi-bb", &["mesh.size=1e-3"]),
        ("fbi-bb-3d", &["mesh.size=2e-3"]),
        ("cavity-exact", &[]),
        ("l-beam", &[]),
    ];
    for (name, changes) in changes {
        let scene = scene::read(&changed(name, changes)).unwrap();
        let simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        let (expected, found) = (memory_estimate(&scene).unwrap().elements, simulation.observe().cost.elements as u64);
        println!("{name} {changes:?}: {expected} elements expected, {found} found");
        assert!((found..=2 * found).contains(&expected), "{name} {changes:?}: {expected} for {found}");
    }
}
