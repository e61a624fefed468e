use super::run::{run, scene};
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::MeshFrame;
use std::f64::consts::PI;

/// Radii, m, and shear modulus, Pa, of `cavity-exact`.
const RADII: [f64; 2] = [5e-3, 0.1];
const SHEAR: f64 = 35e3;
/// Stretches that the table shows.
const SHOWN: [f64; 5] = [1.5, 2.0, 3.0, 4.0, 5.0];
/// A mesh that is never worn.
const FIXED: [(&str, &str); 2] = [("remesh.quality", "0"), ("remesh.min_volume_ratio", "0")];
/// Looks at a run.
const LOOKS: u32 = 400;

/// C₂/(C₁ + C₂) of the Mooney–Rivlin gel.
const SECOND: f64 = 0.1;

/// The cavity of a shell, also of a two-network and a Mooney–Rivlin one, or the bore of a cylinder that keeps its length.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    Sphere,
    /// The elastic network of a two-network gel.
    Networks,
    MooneyRivlin,
    Cylinder,
}

impl Form {
    /// h(λ) of p/G = h(λ_b) − h(λ).
    fn h(self, stretch: f64) -> f64 {
        match self {
            Self::Sphere | Self::Networks => 2.0 / stretch + 0.5 / stretch.powi(4),
            Self::MooneyRivlin => {
                let second = 1.0 / (stretch * stretch) - 2.0 * stretch;
                (1.0 - SECOND) * Self::Sphere.h(stretch) + SECOND * second
            }
            Self::Cylinder => 0.5 / (stretch * stretch) - stretch.ln(),
        }
    }

    fn power(self) -> i32 {
        if self == Self::Cylinder { 2 } else { 3 }
    }

    /// p/G of an incompressible wall at this stretch of its inner radius.
    fn pressure(self, stretch: f64) -> f64 {
        let swelling = (stretch.powi(self.power()) - 1.0) * (RADII[0] / RADII[1]).powi(self.power());
        self.h((1.0 + swelling).powf(1.0 / f64::from(self.power()))) - self.h(stretch)
    }

    /// Volume of the cavity, m³: Σ π Δz (r₀² + r₀r₁ + r₁²)/3 over the facets that were nearer to its wall than to the outer one.
    fn volume(self, frame: &MeshFrame) -> f64 {
        let rest = |node: u32| frame.points[node as usize] - frame.displacements[node as usize];
        let radius = |x: Vector3| if self == Self::Cylinder { x.x } else { x.norm() };
        let is_inner = |facet: &&[u32; 3]| {
            let within = facet[..2].iter().all(|node| radius(rest(*node)) < 2.0 * RADII[0]);
            within && (self != Self::Cylinder || facet[..2].iter().any(|node| rest(*node).z != rest(facet[0]).z))
        };
        let part = |facet: &[u32; 3]| {
            let [a, b] = [0, 1].map(|k| frame.points[facet[k] as usize]);
            PI * (b.z - a.z) * (a.x * a.x + a.x * b.x + b.x * b.x) / 3.0
        };
        frame.cells.facets.iter().filter(is_inner).map(part).sum()
    }
}

/// Pressure against stretch of `cavity-exact`, by shape and mesh size, on a fixed mesh and on meshes that are remade.
pub fn study() {
    println!(
        "| shape | h, mm | meshes | elements | p/p exact − 1, %, at λ = 1.5 | 2 | 3 | 4 | 5 | greatest to 5 | closure | defect | seconds |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for form in [Form::Sphere, Form::Networks, Form::MooneyRivlin, Form::Cylinder] {
        for size in [1e-3, 0.5e-3] {
            for fixed in [true, false] {
                row(form, size, fixed);
            }
        }
    }
}

fn row(form: Form, size: f64, is_fixed: bool) {
    let mut keys = vec![("mesh.size", format!("{size}")), ("remesh.smallest", format!("{size}"))];
    if is_fixed {
        keys.extend(FIXED.map(|(key, value)| (key, value.to_owned())));
    }
    match form {
        Form::Sphere => {}
        Form::Networks => keys.push(("gel.material", "\"two-network\"".to_owned())),
        Form::MooneyRivlin => keys.extend(mooney_rivlin()),
        Form::Cylinder => keys.extend(cylinder(size)),
    }
    let scene = scene("cavity-exact", &keys);
    let (mut start, mut seen) = (None, vec![]);
    let done = run(&scene, LOOKS, |simulation| {
        let frame = simulation.frame();
        let volume = form.volume(&frame);
        let stretch = (volume / *start.get_or_insert(volume)).powf(1.0 / f64::from(form.power()));
        seen.push((stretch, pressure(&scene, frame.time) / SHEAR / form.pressure(stretch) - 1.0));
    });
    let name = match form {
        Form::Sphere => "sphere",
        Form::Networks => "sphere, two-network",
        Form::MooneyRivlin => "sphere, Mooney-Rivlin",
        Form::Cylinder => "cylinder",
    };
    let meshes = done.last.cost.remeshes + 1;
    print!("| {name} | {} | {meshes} | {} ", 1e3 * size, done.last.cost.elements);
    for shown in SHOWN {
        let error =
            seen.iter().find(|(stretch, _)| *stretch >= shown).map(|(_, error)| format!("{:+.2}", 100.0 * error));
        print!("| {} ", error.unwrap_or_default());
    }
    let measured = seen.iter().filter(|(stretch, _)| (SHOWN[0]..=SHOWN[4]).contains(stretch));
    let greatest = measured.map(|(_, error)| error.abs()).fold(0.0, f64::max);
    let energy = &done.last.energy;
    let end = done.failure.unwrap_or_else(|| format!("{:.1}", done.seconds));
    println!("| {:.2} | {:.0e} | {:.1e} | {end} |", 100.0 * greatest, energy.energy_error, energy.energy_defect);
}

/// The pressure of the only load of a scene, Pa.
fn pressure(scene: &Scene, time: f64) -> f64 {
    let history = scene.load[0].history();
    let after = history.partition_point(|(t, _)| *t < time).clamp(1, history.len() - 1);
    let [(t, p), (u, q)] = [history[after - 1], history[after]];
    p + (q - p) * (time - t) / (u - t)
}

/// A slice of a cylinder two cells high instead, its bore blown up by the pressures of the same stretches.
fn cylinder(size: f64) -> Vec<(&'static str, String)> {
    let height = 4.0 * size;
    vec![
        ("gel.shape", format!("{{ cylinder = {{ radius = {}, height = {height}, bore = {} }} }}", RADII[1], RADII[0])),
        ("gel.supports", "{ z_min = \"roller\", z_max = \"roller\" }".to_owned()),
        ("load[1].table", table(Form::Cylinder)),
    ]
}

/// The same shell of a gel of two constants, blown up by the pressures of the same stretches.
fn mooney_rivlin() -> Vec<(&'static str, String)> {
    let [c1, c2] = [1.0 - SECOND, SECOND].map(|part| 0.5 * SHEAR * part);
    vec![
        ("gel.material", "\"mooney-rivlin\"".to_owned()),
        ("gel.constants", format!("{{ c1 = {c1}, c2 = {c2} }}")),
        ("load[1].table", table(Form::MooneyRivlin)),
    ]
}

/// p/G over time of a stretch from 1 to 5.5 that begins and ends at rest.
fn table(form: Form) -> String {
    let stretch = |part: f64| 1.0 + 4.5 * part * part * (3.0 - 2.0 * part);
    let point = |i: u32| {
        let part = f64::from(i) / 20.0;
        format!("[{}, {}]", 0.2 * part, form.pressure(stretch(part)))
    };
    format!("[{}]", (0..=20).map(point).collect::<Vec<_>>().join(", "))
}
