//! Flow of one element that is stretched along an axis, against ordinary differential equations solved apart.
//!
//! At F = diag(λ, λ^−½, λ^−½) the state of a branch is b, the axial component of b̄_i, whose others are b^−½. With
//! q = μ (b − b^−½) and tr b̄_i = b + 2 b^−½, d ln b/dt = 2 λ̇/λ − 2 ε̇ (b + 2 b^−½)/(2b + b^−½) for the power law, and
//! −(b − b^−½)/(τ (b + b^−½/2)) in the place of the last term for the linear dashpot.

use super::*;

const MODULUS: f64 = 4.8e6;

/// Stretch of the element, one branch alone.
struct Ramp {
    dashpot: Dashpot,
    /// λ̇/λ, 1/s.
    rate: f64,
    /// Greatest ln λ.
    strain: f64,
}

impl Ramp {
    /// d ln b/dt, 1/s.
    fn slope(&self, log: f64) -> f64 {
        let (b, across) = (log.exp(), (-0.5 * log).exp());
        let flow = match &self.dashpot {
            Dashpot::Linear(_) => {
                let time = self.time();
                (b - across) / (time * (b + 0.5 * across))
            }
            Dashpot::PowerLaw(law) => {
                let stress = MODULUS * (b - across);
                let rate = if stress > 0.0 { law.rate_at(stress) } else { 0.0 };
                2.0 * rate * (b + 2.0 * across) / (2.0 * b + across)
            }
        };
        2.0 * self.rate - flow
    }

    fn time(&self) -> f64 {
        0.3 * self.strain / self.rate
    }

    /// ln b at the end, by the Runge–Kutta method of fourth order.
    fn solved(&self) -> f64 {
        let n = 40_000;
        let h = self.strain / self.rate / f64::from(n);
        (0..n).fold(0.0, |log, _| {
            let a = self.slope(log);
            let b = self.slope(log + 0.5 * h * a);
            let c = self.slope(log + 0.5 * h * b);
            let d = self.slope(log + h * c);
            log + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        })
    }

    /// ln b at the end, by the element in `n` steps.
    fn stepped(&self, n: u32) -> f64 {
        let gel = TwoNetwork::new(0.0, &[Branch::new(MODULUS, self.dashpot)], EquationOfState::new(2e9, 0.0, 1e9), 1e3);
        let (rest, simplices) = simplex::<3>(Section::Spatial, gel);
        let mut memory = fresh(&simplices);
        advance(&simplices, &rest, (0.0, &mut memory));
        let step = self.strain / self.rate / f64::from(n);
        for i in 1..=n {
            let log = self.strain * f64::from(i) / f64::from(n);
            let (along, across) = (log.exp(), (-0.5 * log).exp());
            let x: Vec<_> = rest.iter().map(|x| Vector::<3>::new(along * x[0], across * x[1], across * x[2])).collect();
            advance(&simplices, &x, (step, &mut memory));
        }
        (memory.last().unwrap().inverse[(0, 0)] * (2.0 * self.strain).exp()).ln()
    }

    /// Checks the order of convergence over four halvings, and the limit by Richardson's extrapolation.
    fn check(&self, order: f64, name: &str) {
        let exact = self.solved();
        let mut found: Vec<f64> = (0..5).map(|k| self.stepped(64 << k)).collect();
        let errors: Vec<f64> = found.iter().map(|log| (log - exact).abs()).collect();
        let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
        let is_exact = errors[4] < 1e-9 * exact.abs();
        assert!(is_exact || orders.iter().all(|own| *own > order), "{name}: {orders:?}, {errors:?}");
        for k in 1..5 {
            // The errors are a series in the step: of its whole powers from the first, or of even ones.
            let part = if order > 1.5 { f64::from(1 << (2 * k)) } else { f64::from(1 << k) };
            found = found.windows(2).map(|pair| pair[1] + (pair[1] - pair[0]) / (part - 1.0)).collect();
        }
        let limit = (found[0] / exact - 1.0).abs();
        assert!(limit < 1e-6, "{name}: {limit:e} from {exact}");
    }
}

#[test]
fn a_power_law_branch_converges_to_the_solution_at_every_rate() {
    for exponent in [0.5, 0.7, 0.85, 1.0] {
        for rate in [1e-3, 1.0, 1e3, 1e6] {
            let law = PowerLaw::new(640.0, exponent);
            // Four times the strain that the stress of this rate takes.
            let strain = (4.0 * law.stress_at(rate) / (3.0 * MODULUS)).min(1.5);
            let ramp = Ramp { dashpot: Dashpot::PowerLaw(law), rate, strain };
            ramp.check(0.9, &format!("m = {exponent}, {rate}/s"));
        }
    }
}

#[test]
fn a_branch_that_saturates_converges_below_its_rate_and_bears_its_stress_above() {
    let law = PowerLaw::saturating(1.1e6, 1200.0, 1.5);
    for rate in [100.0, 600.0] {
        // The strain that the stress of this rate takes: the flow is not yet steady.
        let strain = law.stress_at(rate) / (3.0 * MODULUS);
        Ramp { dashpot: Dashpot::PowerLaw(law), rate, strain }.check(0.9, &format!("{rate}/s"));
    }
    for exponent in [1.5, 3.0] {
        let law = PowerLaw::saturating(1.1e6, 1200.0, exponent);
        for rate in [1e4, 1e6] {
            let b = Ramp { dashpot: Dashpot::PowerLaw(law), rate, strain: 0.5 }.stepped(2000).exp();
            let stress = MODULUS * (b - b.powf(-0.5));
            assert!((stress / 1.1e6 - 1.0).abs() < 1e-12, "m = {exponent}, {rate}/s: {stress} Pa");
        }
    }
}

/// Steady flow of a branch of 4.8 MPa, 600 Pa at 1/s and 0.8 at the rate, 1/s, at which that of Bergström and Boyce bears 3 MPa: they
/// have |λ̇/λ| = ε̇, we ε̇ (λ³ + 2)/(2λ³ + 1).
#[test]
fn steady_flow_differs_from_that_of_bergstrom_and_boyce_by_as_much_as_the_documents_say() {
    let law = PowerLaw::new(600.0, 0.8);
    let rate = law.rate_at(3e6);
    for (strain, part) in [(-1.5, 0.859), (1.5, 1.184)] {
        let ramp = Ramp { dashpot: Dashpot::PowerLaw(law), rate: rate.copysign(strain), strain };
        let b = ramp.stepped(2000).exp();
        let stress = MODULUS * (b - b.powf(-0.5)).abs();
        assert!((stress / 3e6 / part - 1.0).abs() < 2e-3, "{strain}: {stress} Pa");
        let cube = b.powf(1.5);
        let flow = law.rate_at(stress) * (cube + 2.0) / (2.0 * cube + 1.0);
        assert!((flow / rate - 1.0).abs() < 5e-3, "{strain}: {flow}/s, not {rate}/s");
    }
}

#[test]
fn a_linear_branch_converges_with_second_order() {
    for strain in [1e-3, 0.3, 1.5] {
        let rate = 1e3;
        let dashpot = Dashpot::linear(0.3 * strain / rate);
        Ramp { dashpot, rate, strain }.check(1.9, &format!("strain {strain}"));
    }
}

/// Dissipation over μ/2 of a saturating dashpot in a simple shear, after a stress `last`, Pa.
fn dissipated(shear: f64, last: f64) -> f64 {
    let at = IsochoricDeformation::<2, f64>::new(&[[1.0, shear], [0.0, 1.0]], 1.0, 1.0);
    let mut own = SymmetricTensor::diagonal(1.0, 1.0);
    let law = PowerLaw::saturating(1.1e6, 800.0, 3.0);
    flow(&law, 1e7, &at, &IsochoricShape::now(&at), &mut own, last, 1e-7).1
}

#[test]
fn a_stress_that_vanishes_dissipates_nothing_and_small_ones_the_same_by_both_formulas() {
    for shear in [1e-70, 1e-30, 1e-12] {
        // Half of `last` works on the elastic strain that the flow takes, γ/√3.
        let most = 1e3 / (3.0_f64.sqrt() * 1e7) * shear;
        assert!((0.0..=1.001 * most).contains(&dissipated(shear, 1e3)), "{shear:e}: {:e}", dissipated(shear, 1e3));
    }
    // |dev b̄| = √2 γ.
    let [below, above] = [0.999, 1.001].map(|part| dissipated(part * SMALL / 2.0_f64.sqrt(), 0.0));
    assert!((above / below - 1.004).abs() < 1e-3, "{below:e}, {above:e}");
}
