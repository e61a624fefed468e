//! The table of drawn scenes.

use super::ranges::Class;
use super::ride::Ride;

/// Defect of the energy above which a scene is listed by itself.
const LARGE: f64 = 0.05;

/// By class, then those of a large defect and those that stopped, one by one.
pub fn print(rides: &[(u64, Ride)]) {
    println!(
        "| space | scenes | reach their end | remeshings | most in one | refused | closure of energy | of momentum | of angular momentum | mass | least J | defect, %: median, worst | remesh, %: median, worst | updates | s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for class in Class::ALL {
        let of_class: Vec<&Ride> =
            rides.iter().filter(|(seed, _)| Class::of(*seed) == class).map(|(_, ride)| ride).collect();
        if !of_class.is_empty() {
            println!("| {} | {} |", class.name(), row(&of_class));
        }
    }
    for (seed, ride) in rides.iter().filter(|(_, ride)| ride.defect.is_nan() || ride.defect.abs() > LARGE) {
        let Ride { defect, remesh, least, remeshings, .. } = ride;
        println!(
            "\nseed {seed} ({}): defect {:.2} %, of it remeshing {:.2} %, {remeshings} remeshings, least J {least:.3}",
            Class::of(*seed).name(),
            100.0 * defect,
            100.0 * remesh
        );
    }
    for (seed, ride) in rides.iter().filter(|(_, ride)| ride.stop.is_some()) {
        let Ride { stop, part, remeshings, refused, why, .. } = ride;
        println!(
            "\nseed {seed} ({}): {} after {:.0} % of its time, {remeshings} remeshings, {refused} refused, the last {why}",
            Class::of(*seed).name(),
            stop.as_deref().unwrap_or_default(),
            100.0 * part
        );
    }
}

fn row(rides: &[&Ride]) -> String {
    let worst = |of: &dyn Fn(&Ride) -> f64| rides.iter().map(|ride| of(ride)).fold(0.0, f64::max);
    let spread = |of: &dyn Fn(&Ride) -> f64| {
        let mut all: Vec<f64> = rides.iter().map(|ride| 100.0 * of(ride)).collect();
        all.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        format!("{:.2}, {:.2}", all[all.len() / 2], all[all.len() - 1])
    };
    format!(
        "{} | {} | {} | {} | {} | {:.0e} | {:.0e} | {:.0e} | {:.0e} | {:.3} | {} | {} | {:.1e} | {:.0}",
        rides.len(),
        rides.iter().filter(|ride| ride.stop.is_none()).count(),
        rides.iter().map(|ride| ride.remeshings).sum::<u64>(),
        rides.iter().map(|ride| ride.remeshings).max().unwrap_or_default(),
        rides.iter().map(|ride| ride.refused).sum::<usize>(),
        worst(&|ride| ride.closure[0]),
        worst(&|ride| ride.closure[1]),
        worst(&|ride| ride.closure[2]),
        worst(&|ride| ride.mass),
        rides.iter().map(|ride| ride.least).fold(f64::INFINITY, f64::min),
        spread(&|ride| ride.defect),
        spread(&|ride| ride.remesh),
        rides.iter().map(|ride| ride.updates).sum::<f64>(),
        rides.iter().map(|ride| ride.seconds).sum::<f64>(),
    )
}
