//! States that were damaged: bits flipped, cut off, mixed with others, or forged under a checksum that is right.

use super::host::{ERROR, Host, OK};
use super::random::Random;
use super::tally::Fate;
use ballistic_gel::fmi2::abi::*;
use std::ffi::c_int;

/// A panic was caught inside.
const FATAL: c_int = 4;
/// Bytes before the body: magic, version, digest, length.
const HEADER: usize = 36;
/// Bytes of the checksum at the end.
const TRAILER: usize = 4;
/// Communication step, s: some element steps of every scene.
const STEP: f64 = 2e-6;

/// Scenes and states of them, as bytes.
pub struct States {
    of: Vec<(String, Vec<Vec<u8>>)>,
}

impl States {
    /// States from several phases of these scenes.
    pub fn of(scenes: &[String]) -> Self {
        Self { of: scenes.iter().map(|scene| (scene.clone(), states(scene))).collect() }
    }
}

fn states(scene: &str) -> Vec<Vec<u8>> {
    let mut host = Host::with(scene);
    let mut states = vec![host.bytes()];
    host.enter();
    host.get("energy.kinetic");
    states.push(host.bytes());
    // SAFETY: a live component.
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, OK);
    for (from, n) in [(0.0, 1), (STEP, 10)] {
        host.steps(from, STEP, n);
        states.push(host.bytes());
    }
    states
}

/// Damages a state and restores it; taken if the instance goes there.
pub fn attempt(states: &States, seed: u64) -> Result<Fate, String> {
    let mut random = Random(seed);
    let (scene, own) = random.pick(&states.of);
    let mut bytes = random.pick(own).clone();
    let other = random.pick(&random.clone().pick(&states.of).1).clone();
    damage(&mut bytes, &other, &mut random);
    let mut host = Host::with(scene);
    let runs = random.once_in(2);
    if runs {
        host.start();
        host.steps(0.0, STEP, 1);
    }
    let before = runs.then(|| host.digest());
    let status = host.restore(&bytes);
    let lines = host.lines();
    match status {
        FATAL => Err(format!("panic: {lines:?}")),
        ERROR if lines.is_empty() => Err("refused without a word".to_owned()),
        ERROR => match before {
            Some(before) => unharmed(&mut host, before),
            None => Ok(Fate::Refused),
        },
        _ => goes_on(&mut host),
    }
}

/// What was refused has changed nothing.
fn unharmed(host: &mut Host, before: [u8; 16]) -> Result<Fate, String> {
    if host.digest() != before {
        return Err("a refused state has changed the instance".to_owned());
    }
    // SAFETY: a live component.
    match unsafe { fmi2DoStep(host.c, STEP, STEP, 0) } {
        OK => Ok(Fate::Refused),
        status => Err(format!("after a refused state a step gives {status}: {:?}", host.lines())),
    }
}

/// What was taken can be stepped, or says why not.
fn goes_on(host: &mut Host) -> Result<Fate, String> {
    for _ in 0..2 {
        let mut now = 0.0;
        // SAFETY: a live component, and one value.
        let status = unsafe { fmi2GetRealStatus(host.c, 2, &raw mut now).max(fmi2DoStep(host.c, now, STEP, 0)) };
        let lines = host.lines();
        if status == FATAL {
            return Err(format!("panic after a damaged state: {lines:?}"));
        }
        if status != OK && lines.is_empty() {
            return Err(format!("a step gives {status} without a word"));
        }
    }
    Ok(Fate::Taken)
}

fn damage(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    match random.below(8) {
        0 => bytes.truncate(random.below(bytes.len() + 1)),
        1 => bytes.extend((0..=random.below(40)).map(|i| i as u8)),
        2 => bytes[8] = random.below(256) as u8,
        3 => flip(bytes, 1 + random.below(3), random),
        4 => {
            let from = random.below(other.len());
            bytes.truncate(from);
            bytes.extend_from_slice(&other[from..]);
        }
        _ => forge(bytes, random),
    }
}

fn flip(bytes: &mut [u8], n: usize, random: &mut Random) {
    for _ in 0..n {
        let at = random.below(bytes.len());
        bytes[at] ^= 1 << random.below(8);
    }
}

/// Changes the body and makes length and checksum fit.
fn forge(bytes: &mut Vec<u8>, random: &mut Random) {
    let mut body = bytes[HEADER..bytes.len() - TRAILER].to_vec();
    // What is small, and says how much there is of the rest, is at the front, behind the text of the scene.
    let text = body.windows(6).rposition(|part| part == b"[mesh]").unwrap_or(0);
    let near = |random: &mut Random, n: usize| {
        let from = if random.once_in(2) { text.min(n) } else { 0 };
        let most = if random.once_in(2) { 1500 } else { usize::MAX };
        from + random.below((n - from).clamp(1, most))
    };
    for _ in 0..=random.below(3) {
        let at = near(random, body.len().max(1));
        match random.below(4) {
            _ if at >= body.len() => {}
            0 => flip(&mut body[at..], 1, random),
            1 => body.truncate(at),
            2 => body.insert(at, random.below(256) as u8),
            _ => {
                let number = random.real().to_le_bytes();
                let to = (at + 8).min(body.len());
                body[at..to].copy_from_slice(&number[..to - at]);
            }
        }
    }
    bytes.truncate(HEADER);
    bytes[28..].copy_from_slice(&(body.len() as u64).to_le_bytes());
    bytes.extend(body);
    let checksum = crc32fast::hash(bytes).to_le_bytes();
    bytes.extend(checksum);
}
