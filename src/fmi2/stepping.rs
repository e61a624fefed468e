//! `fmi2DoStep` and its status queries.

use super::call::{CallError, format_number};
use super::inputs::BodyLoad;
use super::instance::{ExperimentClock, FmuInstance};
use super::lifecycle::LifecyclePhase;
use super::memory::reserve_for_step;
use super::model::BuiltModel;
use super::status::CallStatus;

/// Relative tolerance of times, for the round-off of repeated additions of a step.
const TOLERANCE: f64 = 1e-9;
/// Greatest spacing of double-precision numbers relative to a step. At 1e-9 a start at 100 s would refuse steps of a
/// microsecond, whose ends are known there to 1e-14 s, far below an element's step. At 1e-2 the end of a run of many
/// steps is visibly off.
const MAX_RELATIVE_SPACING: f64 = 1e-6;

impl ExperimentClock {
    /// Returns the end of a step from `current` of length `step`, s.
    fn end_of(&self, current: f64, step: f64) -> Result<f64, CallError> {
        if !(step.is_finite() && step > 0.0) {
            return Err(CallError::value("communicationStepSize", step, "a finite length above 0 s"));
        }
        let slack = TOLERANCE * (self.now.abs().max(self.start.abs()).max(step));
        if current.is_nan() || (current - self.now).abs() > slack {
            let expected = format!("{} s, the end of the last step", format_number(self.now));
            return Err(CallError::value("currentCommunicationPoint", current, expected));
        }
        // Some importers add up their steps, and end a run with the round-off that is left of it.
        let is_remnant = step <= TOLERANCE * (current - self.start);
        let end = if is_remnant { self.now.max(current + step) } else { current + step };
        let spacing = spacing(current.abs().max(self.start.abs()));
        if !is_remnant && (spacing > MAX_RELATIVE_SPACING * step || end <= self.now) {
            let shortest = spacing / MAX_RELATIVE_SPACING;
            let expected = format!(
                "at least {shortest:e} s: at {} s, after a startTime of {} s, double precision cannot tell the \
                 ends of shorter steps apart. Use a startTime nearer to 0",
                format_number(current),
                format_number(self.start)
            );
            return Err(CallError::value("communicationStepSize", step, expected));
        }
        match self.stop {
            Some(stop) if end > stop + TOLERANCE * stop.abs().max(self.start.abs()).max(step) => {
                Err(CallError::value("end of the step", end, format!("at most stopTime = {} s", format_number(stop))))
            }
            Some(_) | None => Ok(end),
        }
    }
}

impl FmuInstance {
    /// Performs one communication step.
    pub(super) fn do_step(&mut self, current: f64, step: f64) -> Result<CallStatus, CallError> {
        self.refuse_after_failure()?;
        let end = self.clock.end_of(current, step)?;
        let since_start = (end - self.clock.start).max(0.0);
        self.refuse_beyond_ticks(step, since_start)?;
        let is_first_step = self.clock.now == self.clock.start;
        let model = self.model.as_mut().expect("the ticks were checked against it");
        self.inputs.hand_over(model, is_first_step, step, &mut self.handed)?;
        let _reserve = reserve_for_step(&model.simulation)?;
        let begun = model.simulation.time();
        let succeeded = model.advance(&self.handed, since_start);
        let reached = model.simulation.time();
        let acted = |inputs| BodyLoad::at_step_end(inputs, model.scene.coupling.mode, reached - begun);
        self.inputs.rates.clear();
        self.inputs.acted.clear();
        self.inputs.acted.extend(self.handed.iter().map(acted));
        if !succeeded {
            self.phase = LifecyclePhase::StepFailed;
            self.clock.now = self.clock.now.max(self.clock.start + reached);
            self.record();
            self.refuse_after_failure()?;
        }
        self.clock.now = end;
        Ok(self.record())
    }

    /// Returns the end of the last completed step, s; after a failed step, the time reached by the simulation.
    pub(super) fn last_successful_time(&self) -> f64 {
        self.clock.now
    }

    /// Returns true if the simulation has stopped by itself.
    pub(super) fn has_stopped(&self) -> bool {
        self.failure().is_some()
    }

    /// Refuses a step whose end lies beyond the range of exact ticks.
    fn refuse_beyond_ticks(&mut self, step: f64, since_start: f64) -> Result<(), CallError> {
        let latest = self.model()?.simulation.latest();
        if since_start <= latest {
            return Ok(());
        }
        let expected =
            format!("a step that ends at most {latest:e} s after the start: the ticks of later times are not exact");
        Err(CallError::value("communicationStepSize", step, expected))
    }

    fn failure(&self) -> Option<String> {
        self.model.as_ref().and_then(BuiltModel::failure)
    }

    fn refuse_after_failure(&self) -> Result<(), CallError> {
        self.failure().map_or(Ok(()), |reason| Err(CallError::Stopped { reason }))
    }
}

/// Returns the distance from a number to the next larger number.
fn spacing(x: f64) -> f64 {
    x.next_up() - x
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCK: ExperimentClock = ExperimentClock { start: 0.0, stop: Some(1e-2), now: 5e-3 };

    #[test]
    fn a_step_without_a_sensible_length_is_refused() {
        for step in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
            assert!(CLOCK.end_of(5e-3, step).unwrap_err().to_string().contains("communicationStepSize"), "{step}");
        }
    }

    #[test]
    fn the_stop_time_is_met_to_round_off_and_not_passed() {
        assert!(CLOCK.end_of(5e-3, 5e-3 * (1.0 + 1e-12)).is_ok());
        assert!(CLOCK.end_of(5e-3, 5e-3 * (1.0 + 1e-6)).unwrap_err().to_string().contains("stopTime"));
        assert!(ExperimentClock { stop: None, ..CLOCK }.end_of(5e-3, 1.0).is_ok());
    }

    #[test]
    fn a_step_that_a_large_time_swallows_is_refused() {
        for (start, step) in [(1e9, 1e-8), (1e12, 1e-5), (1e9, 1e-5), (-1e9, 1e-5)] {
            let clock = ExperimentClock { start, stop: None, now: start };
            let refused = clock.end_of(start, step).unwrap_err().to_string();
            assert!(refused.starts_with("communicationStepSize = ") && refused.contains("startTime"), "{refused}");
        }
        for (start, step) in [(0.0, 1e-12), (100.0, 1e-6), (1e9, 1.0), (-0.25, 1e-8)] {
            assert!(ExperimentClock { start, stop: None, now: start }.end_of(start, step).is_ok(), "{step} at {start}");
        }
    }

    #[test]
    fn a_round_off_remainder_before_the_stop_time_is_a_valid_step() {
        for (step, stop) in [(1e-5_f64, 1e-2), (5e-6, 4e-3), (1e-5, 1.0)] {
            let mut clock = ExperimentClock { start: 0.0, stop: Some(stop), now: 0.0 };
            let mut last = step;
            while clock.now < stop {
                last = step.min(stop - clock.now);
                clock.now = clock.end_of(clock.now, last).unwrap();
            }
            assert!(last < 1e-6 * step && clock.now == stop, "{last} at {stop}");
            assert_eq!(clock.end_of(stop * (1.0 + 1e-12), 1e-20).unwrap(), stop * (1.0 + 1e-12));
            assert_eq!(clock.end_of(stop * (1.0 - 1e-12), 1e-20).unwrap(), stop, "time does not go back");
        }
    }

    #[test]
    fn a_step_starts_where_the_last_one_ended() {
        assert!(CLOCK.end_of(5e-3 + 1e-17, 1e-3).is_ok());
        assert!(CLOCK.end_of(4e-3, 1e-3).unwrap_err().to_string().contains("0.005 s"));
        assert!(CLOCK.end_of(f64::NAN, 1e-3).is_err());
    }
}
