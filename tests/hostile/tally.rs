//! What comes of hostile inputs: how many were taken, refused, and what should not have happened.

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Once};
use std::time::{Duration, Instant};

/// Longer than any input may take, s: a hundred times what the slowest of them takes on an idle machine.
const LONGEST: f64 = 60.0;

thread_local! {
    static TRYING: Cell<bool> = const { Cell::new(false) };
    static SAID: RefCell<String> = const { RefCell::new(String::new()) };
}

/// What became of one input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It was used.
    Taken,
    /// It was refused, and said why.
    Refused,
}

/// What became of many.
#[derive(Debug, Default)]
pub struct Tally {
    /// Inputs that were used.
    pub taken: u64,
    /// Inputs that were refused.
    pub refused: u64,
    /// Seed and story of each that panicked, took too long, or gave nonsense.
    pub found: Vec<(u64, String)>,
}

impl Tally {
    /// All inputs.
    pub fn inputs(&self) -> u64 {
        self.taken + self.refused + self.found.len() as u64
    }

    /// Tries one input: a panic, a long time and an `Err` are findings.
    pub fn attempt(&mut self, seed: u64, input: impl FnOnce() -> Result<Fate, String>) {
        let begun = Instant::now();
        TRYING.set(true);
        let outcome = catch_unwind(AssertUnwindSafe(input));
        TRYING.set(false);
        let seconds = begun.elapsed().as_secs_f64();
        let story = match outcome {
            Err(_) => SAID.with_borrow(|said| format!("panic: {said}")),
            Ok(Err(nonsense)) => nonsense,
            Ok(Ok(_)) if seconds > LONGEST => format!("took {seconds:.0} s"),
            Ok(Ok(Fate::Taken)) => return self.taken += 1,
            Ok(Ok(Fate::Refused)) => return self.refused += 1,
        };
        self.found.push((seed, story));
    }

    /// Tries the inputs of the seeds from `seed` on until `enough` says so.
    pub fn run(
        seed: u64,
        mut enough: impl FnMut(&Self) -> bool,
        mut input: impl FnMut(u64) -> Result<Fate, String>,
    ) -> Self {
        listen();
        let (mut tally, at) = (Self::default(), watched());
        while !enough(&tally) {
            let own = seed.wrapping_add(tally.inputs());
            at.store(own, Ordering::Relaxed);
            tally.attempt(own, || input(own));
        }
        tally
    }

    /// So many inputs.
    pub fn of(seed: u64, inputs: u64, input: impl FnMut(u64) -> Result<Fate, String>) -> Self {
        Self::run(seed, |tally| tally.inputs() >= inputs, input)
    }

    /// Inputs for this long.
    pub fn lasting(seed: u64, time: Duration, input: impl FnMut(u64) -> Result<Fate, String>) -> Self {
        let (begun, mut told) = (Instant::now(), 0);
        let enough = |tally: &Self| {
            if tally.found.len() > told {
                told = tally.found.len();
                eprintln!("seed {}: {}", tally.found[told - 1].0, tally.found[told - 1].1);
            }
            begun.elapsed() >= time
        };
        Self::run(seed, enough, input)
    }
}

/// Keeps what a panic in an input says, instead of printing it.
fn listen() {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(|| {
        let others = take_hook();
        set_hook(Box::new(
            move |panic| {
                if TRYING.get() { SAID.set(panic.to_string().replace('\n', " ")) } else { others(panic) }
            },
        ));
    });
}

/// Where the seed under way is to be put; one that stays there is named, in case it never ends.
fn watched() -> Arc<AtomicU64> {
    let at = Arc::new(AtomicU64::new(0));
    let watched = Arc::downgrade(&at);
    std::thread::spawn(move || {
        let (mut last, mut told) = (u64::MAX, u64::MAX);
        loop {
            std::thread::sleep(Duration::from_secs_f64(LONGEST));
            let Some(at) = watched.upgrade() else { return };
            let now = at.load(Ordering::Relaxed);
            if now == last && now != told {
                eprintln!("seed {now}: not done after {LONGEST} s");
                told = now;
            }
            last = now;
        }
    });
    at
}
