//! Cracks around a shot, estimated from the cavity: total crack length of each slice of one centimetre.

use super::cavity::CavityProfile;
use super::shot_line::CENTIMETRES;
use crate::output::files::format_cell;
use std::f64::consts::PI;
use std::fmt::Write;

/// Total crack length per circumference that the cavity has beyond the projectile. Assumed: no table of measured
/// cracks could be read. A ring of gel of radius r around a hole of radius R is stretched by √(1 + R²/r²); six cracks
/// that end where the stretch is 1.5 have 0.85 π times the diameter of the hole.
const CRACK_FACTOR: f64 = 1.0;
/// Tolerance of a depth relative to a slice, for round-off.
const ROUND_OFF: f64 = 1e-9;

/// Slice of one centimetre of depth, as a laboratory cuts the gel; the last ends at the greatest depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::output) struct CrackSlice {
    /// Depth of the upper face, m.
    pub(in crate::output) depth_from: f64,
    /// Depth of the lower face, m.
    pub(in crate::output) depth_to: f64,
    /// Greatest diameter of the cavity in the slice over the run, m, below one projectile diameter: the crater above
    /// does not count. NaN if no cavity behind the projectile was enclosed by gel there.
    pub(in crate::output) cavity_diameter: f64,
    /// Diameter up to which the projectile parts the gel without cracks, m. Assumed: the width of the projectile
    /// across the line of flight, of an expanding projectile at the end.
    pub(in crate::output) tear_diameter: f64,
    /// Energy given to the gel in the slice, J.
    pub(in crate::output) energy: f64,
    /// Total crack length k π max(0, D − d), m, an estimate: D is the cavity diameter, d the tear diameter. NaN
    /// without a cavity.
    pub(in crate::output) crack_length: f64,
}

/// Returns the slices down to the greatest depth, m. `energies` are those of each centimetre, J.
pub(super) fn slices(tear_diameter: f64, depth: f64, energies: &[f64], profiles: &[CavityProfile]) -> Vec<CrackSlice> {
    let curves = profiles.iter().flat_map(CavityProfile::curve).filter(|(depth, _)| *depth > tear_diameter);
    let widest = widest_by_slice(curves, energies.len());
    let slice = |((i, energy), widest): ((usize, &f64), Option<f64>)| {
        let end = if i + 1 == energies.len() { depth } else { (i + 1) as f64 / CENTIMETRES };
        CrackSlice {
            depth_from: i as f64 / CENTIMETRES,
            depth_to: end,
            cavity_diameter: widest.unwrap_or(f64::NAN),
            tear_diameter,
            energy: *energy,
            crack_length: widest.map_or(f64::NAN, |widest| crack_length(widest, tear_diameter)),
        }
    };
    energies.iter().enumerate().zip(widest).map(slice).collect()
}

/// Returns the text of `cracks.csv`.
pub(super) fn csv(slices: &[CrackSlice]) -> String {
    let mut text = String::from("depth_from_m,depth_to_m,cavity_diameter_m,tear_diameter_m,energy_J,crack_length_m\n");
    for slice in slices {
        let CrackSlice { depth_from, depth_to, cavity_diameter, tear_diameter, energy, crack_length } = *slice;
        let row = [depth_from, depth_to, cavity_diameter, tear_diameter, energy, crack_length].map(format_cell);
        writeln!(text, "{}", row.join(",")).expect("a string grows");
    }
    text
}

/// Returns the estimated total crack length of a slice, m.
fn crack_length(cavity_diameter: f64, tear_diameter: f64) -> f64 {
    CRACK_FACTOR * PI * (cavity_diameter - tear_diameter).max(0.0)
}

/// Returns the greatest diameter in each of the first `n` slices, m, of depths, m, and radii, m. A face belongs to both
/// of its slices.
fn widest_by_slice(curves: impl Iterator<Item = (f64, f64)>, n: usize) -> Vec<Option<f64>> {
    let mut widest: Vec<Option<f64>> = vec![None; n];
    for (depth, radius) in curves {
        let place = depth * CENTIMETRES;
        let first = ((place * (1.0 - ROUND_OFF)).ceil() as usize).saturating_sub(1).min(n);
        let end = ((place * (1.0 + ROUND_OFF)) as usize + 1).min(n);
        for slice in &mut widest[first..end] {
            *slice = Some(slice.map_or(2.0 * radius, |before| before.max(2.0 * radius)));
        }
    }
    widest
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEAR: f64 = 0.0045;

    /// Returns a cavity in the first 35 mm, whose radius is given by the depth, m.
    fn profile(time: f64, radius: impl Fn(f64) -> f64) -> CavityProfile {
        let radii =
            (1..=60).map(|k| f64::from(k) * 1e-3).map(|depth| Some(if depth < 0.0355 { radius(depth) } else { 0.0 }));
        CavityProfile::with_radii(time, radii.collect())
    }

    fn lengths(profiles: &[CavityProfile]) -> Vec<f64> {
        slices(TEAR, 0.045, &[4.0, 3.0, 2.0, 1.0, 0.5], profiles).iter().map(|slice| slice.crack_length).collect()
    }

    #[test]
    fn cracks_of_a_cone_follow_from_the_upper_face_of_each_slice_below_the_entry() {
        let found = lengths(&[profile(0.0, |depth| 0.03 - 0.5 * depth)]);
        let expected = [0.005, 0.01, 0.02, 0.03].map(|depth| PI * (0.06 - depth - TEAR));
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
        assert!(found.len() == 5 && found[4].is_nan(), "{found:?}: no cavity in the last slice");
    }

    #[test]
    fn a_cavity_narrower_than_the_projectile_has_no_cracks() {
        assert_eq!(lengths(&[profile(0.0, |_| 0.5 * TEAR - 1e-6)])[..4], [0.0; 4]);
        assert!(lengths(&[]).iter().all(|length| length.is_nan()));
    }

    #[test]
    fn the_crater_of_the_entry_has_no_cracks() {
        let crater = profile(0.0, |depth| if depth < TEAR { 0.08 } else { 0.01 });
        assert!((lengths(&[crater])[0] - PI * (0.02 - TEAR)).abs() < 1e-12);
        let wide = slices(0.02, 0.045, &[1.0; 5], &[profile(0.0, |_| 0.02)]);
        assert!(wide[..2].iter().all(|slice| slice.crack_length.is_nan()) && wide[2].crack_length > 0.0);
    }

    #[test]
    fn the_greatest_diameter_over_time_counts() {
        let [small, great] = [0.006, 0.02].map(|radius| profile(radius, move |_| radius));
        let expected = lengths(std::slice::from_ref(&great));
        assert_eq!(lengths(&[small.clone(), great.clone(), small.clone()])[..4], expected[..4]);
        assert_eq!(lengths(&[great, small])[..4], expected[..4]);
    }

    #[test]
    fn slices_meet_down_to_the_greatest_depth_with_all_of_the_energy() {
        let found = slices(TEAR, 0.045, &[4.0, 3.0, 2.0, 1.0, 0.5], &[profile(0.0, |_| 0.02)]);
        assert!(found.windows(2).all(|pair| pair[0].depth_to == pair[1].depth_from));
        assert_eq!((found[0].depth_from, found[4].depth_from, found[4].depth_to), (0.0, 0.04, 0.045));
        assert_eq!(found.iter().map(|slice| slice.energy).sum::<f64>(), 10.5);
        let text = csv(&found);
        assert_eq!(text.lines().count(), 6);
        assert_eq!(text.lines().last(), Some("4e-2,4.5e-2,,4.5e-3,5e-1,"), "empty cells without a cavity");
    }
}
