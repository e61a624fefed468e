//! Scene text of the bodies that arrive out of another gel.

use super::arrival::{AirFlight, Arrival, ArrivingBody};
use ballistic_gel::scene::{LIBRARY_VERSION, LibraryProjectile, LibraryValue, ProjectileSpec};
use serde::Serialize;
use std::fmt::Write;

/// Comment on the run from which the bodies come, and on their flight.
pub fn origin(arrival: &Arrival) -> String {
    let folder = arrival.folder.display().to_string();
    let Arrival { scene, left_out, flight, bodies, .. } = arrival;
    let AirFlight { gap, exit_time, row_speed, start_time, duration, drift: [x, y], .. } = flight;
    let mut text = format!(
        "# Bodies: as they have left the gel of the run {} of the scene {scene} through its back face. The projectile\n\
         # left at {:.2} m/s after {:.4} ms. Place, attitude and spin are those of the next row of the history, at {:.4} ms, where\n\
         # it has {row_speed:.2} m/s. The block stands {gap:?} m behind that gel: {:.4} ms of flight, straight and turning as a free\n\
         # body, without drag and gravity, which are\n\
         # {}.\n\
         # The block is parallel to the first one, and the projectile meets its middle: in the axes of the first one it\n\
         # arrives at x = {:.3} mm, y = {:.3} mm.\n",
        folder.escape_debug(),
        arrival.speed(),
        1e3 * exit_time,
        1e3 * start_time,
        1e3 * duration,
        flight.left_out(),
        1e3 * x,
        1e3 * y
    );
    if bodies[0].delay > 0.0 {
        let delay = 1e3 * bodies[0].delay;
        writeln!(text, "# A fragment touches the block first, and the projectile {delay:.4} ms later.")
            .expect("a string grows");
    }
    if !left_out.is_empty() {
        let names = left_out.join(", ");
        writeln!(
            text,
            "# Left out, as they had not left that gel through its back face when the run ended, or do not fly with the\n# projectile: {names}."
        )
        .expect("a string grows");
    }
    text
}

/// Tables of projectile and fragments.
pub fn bodies(arrival: &Arrival) -> String {
    let [projectile, fragments @ ..] = &arrival.bodies[..] else { return String::new() };
    let place = if projectile.delay > 0.0 { "# Above the gel." } else { "# Touching the gel." };
    let mut text = format!("[projectile]\n{}", body(&projectile.spec, place));
    for ArrivingBody { name, spec, delay } in fragments {
        let place = format!("# It touches the gel after {:.4} ms.", 1e3 * delay);
        write!(text, "\n[[fragment]] # {name} of that run.\n{}", body(spec, &place)).expect("a string grows");
    }
    text
}

/// Keys of a body: those of the library as comments beside its name.
fn body(spec: &ProjectileSpec, place: &str) -> String {
    let ProjectileSpec { position, velocity, orientation, angular_velocity, .. } = spec;
    let turned =
        if *orientation == [1.0, 0.0, 0.0, 0.0] { String::new() } else { format!("orientation = {orientation:?}\n") };
    let spin = if *angular_velocity == [0.0; 3] {
        String::new()
    } else {
        format!("angular_velocity = {angular_velocity:?}\n")
    };
    format!("{}{place}\nposition = {position:?}\nvelocity = {velocity:?}\n{turned}{spin}", constants(spec))
}

/// Mass, shape, inertia and expansion of a body.
fn constants(spec: &ProjectileSpec) -> String {
    let named = spec.library.as_deref().and_then(LibraryProjectile::named);
    let expansion = spec.expansion.map(|expansion| line("expansion", &expansion)).unwrap_or_default();
    if let Some(projectile) = named.as_ref().filter(|projectile| projectile.differences(spec).is_empty()) {
        let values = projectile.values_of(spec).into_iter().filter(|value| value.quantity() != "expansion");
        let values: String = values.map(|value| commented(&value)).collect();
        return format!("library = \"{}\"\nlibrary_version = {LIBRARY_VERSION}\n{values}{expansion}", projectile.name);
    }
    let name = spec.library.as_ref().map(|name| line("library", name));
    let version = spec.library_version.filter(|_| name.is_some()).map(|version| line("library_version", &version));
    let mass = spec.mass.map(|mass| line("mass", &mass));
    let inertia = spec.inertia.map(|inertia| line("inertia", &inertia));
    let all =
        [name, version, mass, Some(line("shape", &spec.shape)), inertia].into_iter().flatten().collect::<String>();
    all + &expansion
}

/// Comment of a value that the library gives, with its source.
pub fn commented(value: &LibraryValue) -> String {
    let LibraryValue { key, value, source } = value;
    format!("# {key} = {value} # {source}\n")
}

/// Line of a key and its value as TOML.
fn line(key: &str, value: &impl Serialize) -> String {
    let value = toml::Value::try_from(value).expect("a value of a scene consists of tables, numbers and text");
    format!("{key} = {value}\n")
}
