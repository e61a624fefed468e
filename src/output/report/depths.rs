//! Which curves of a shot the report shows along the way of the projectile.

use super::plot::{Across, Curve, Height, Plot};
use crate::output::penetration::{Along, Penetration};

/// Yaw below which nothing is to be seen, degrees.
const STRAIGHT: f64 = 0.01;

/// All plots against depth.
pub(super) fn charts(shot: &Penetration) -> String {
    let plots = [speed(shot), force(shot), energy(shot), yaw(shot), cavity(shot)];
    let figures: String = plots.iter().filter(|plot| !plot.curves.is_empty()).map(Plot::figure).collect();
    format!("<section><h2>Along the way of the projectile</h2>\n{figures}</section>\n")
}

fn speed(shot: &Penetration) -> Plot {
    plot(shot, "Speed of the projectile by depth", "m/s", vec![along(shot, "speed", |_, place| place.velocity)])
}

fn force(shot: &Penetration) -> Plot {
    let curve = along(shot, "mean over 4 mm of depth", |shot, place| shot.track.force(place.depth).unwrap_or(f64::NAN));
    plot(shot, "Force on the projectile by depth", "N", vec![curve])
}

/// Steps: one level for each centimetre.
fn energy(shot: &Penetration) -> Plot {
    let (energies, end) = (shot.track.energy_per_centimetre(), depth(shot));
    let level =
        |(i, energy): (usize, &f64)| [(i as f64 / 100.0, *energy), (((i + 1) as f64 / 100.0).min(end), *energy)];
    let points = energies.iter().enumerate().flat_map(level).collect();
    let curve = Curve { name: "in each centimetre".to_owned(), points };
    plot(shot, "Energy given to the gel by depth", "J", vec![curve])
}

/// Of a projectile that flies straight there is none.
fn yaw(shot: &Penetration) -> Plot {
    let curve = along(shot, "between axis and velocity", |_, place| place.yaw.to_degrees());
    let turns = curve.points.iter().any(|(_, yaw)| *yaw > STRAIGHT);
    plot(shot, "Yaw of the projectile by depth", "°", if turns { vec![curve] } else { vec![] })
}

fn cavity(shot: &Penetration) -> Plot {
    let cavity = &shot.cavity;
    let curves = [
        ("temporary cavity: greatest of the run", &cavity.temporary),
        ("when it was widest", &cavity.widest),
        ("at the end", &cavity.last),
    ];
    let curves = curves.map(|(name, points)| Curve { name: name.to_owned(), points: points.clone() });
    let curves = curves.into_iter().filter(|curve| !curve.points.is_empty()).collect();
    plot(shot, "Radius of the cavity by depth", "m", curves)
}

fn along(shot: &Penetration, name: &str, value: impl Fn(&Penetration, &Along) -> f64) -> Curve {
    let points = shot.track.table().iter().map(|place| (place.depth, value(shot, place))).collect();
    Curve { name: name.to_owned(), points }
}

fn plot(shot: &Penetration, title: &'static str, unit: &'static str, curves: Vec<Curve>) -> Plot {
    Plot {
        title,
        unit,
        height: Height::FromZero,
        across: Across { name: "depth", unit: "m", range: 0.0..depth(shot) },
        curves,
    }
}

fn depth(shot: &Penetration) -> f64 {
    shot.track.table().last().map_or(0.0, |last| last.depth)
}
