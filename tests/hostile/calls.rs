//! Calls of the C interface in any order with any arguments that the standard lets an importer pass by mistake: null pointers,
//! numbers that are none, references of nothing, sizes of 0, states of other instances.

use super::host::{Resources, reference};
use super::random::Random;
use super::tally::Fate;
use ballistic_gel::fmi2::abi::*;
use ballistic_gel::fmi2::{CallbackFunctions, VariablePorts};
use std::ffi::{CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};

/// A panic was caught inside.
const FATAL: c_int = 4;
/// Instances of a thread at a time.
const INSTANCES: usize = 3;
/// Longest step, in steps of the smallest element.
const LONGEST: f64 = 20.0;

/// What instances are made of.
pub struct Stage {
    archive: Resources,
    scenes: Vec<PathBuf>,
    references: Vec<u32>,
}

impl Stage {
    /// A folder with these scenes; the first of them is packed.
    pub fn of(texts: &[String]) -> Self {
        let archive = Resources::packed(&texts[0], &[]);
        let write = |(i, text): (usize, &String)| {
            let path = archive.folder.path().join(if i == 0 { "scene.toml".to_owned() } else { format!("{i}.toml") });
            std::fs::write(&path, text).expect("a temporary file can be written");
            path
        };
        let scenes = texts.iter().enumerate().map(write).collect();
        let references = VariablePorts::all().scalars().map(|scalar| scalar.reference()).collect();
        Self { archive, scenes, references }
    }

    /// GUID and URI of the resources of the packed archive.
    fn identity(&self) -> [&str; 2] {
        [&self.archive.guid, &self.archive.uri].map(|text| text.to_str().expect("both are ASCII"))
    }

    fn path(&self) -> &Path {
        self.archive.folder.path()
    }
}

/// What one importer holds.
struct Importer<'a> {
    stage: &'a Stage,
    random: Random,
    instances: Vec<*mut c_void>,
    states: Vec<*mut c_void>,
    /// The calls of late and what they returned.
    story: Vec<(&'static str, c_int)>,
}

/// A sequence of calls, or every fourth time three at once; taken if some step was done.
pub fn attempt(stage: &Stage, seed: u64) -> Result<Fate, String> {
    if !seed.is_multiple_of(4) {
        return sequence(stage, seed);
    }
    std::thread::scope(|scope| {
        let spawn = |i: u64| scope.spawn(move || sequence(stage, seed ^ (i << 60)));
        let threads = [1, 2, 3].map(spawn);
        let fates = threads.map(|thread| thread.join().unwrap_or_else(|_| Err("a thread panicked".to_owned())));
        let fates: Vec<Fate> = fates.into_iter().collect::<Result<_, _>>()?;
        Ok(if fates.contains(&Fate::Taken) { Fate::Taken } else { Fate::Refused })
    })
}

fn sequence(stage: &Stage, seed: u64) -> Result<Fate, String> {
    let mut importer = Importer { stage, random: Random(seed), instances: vec![], states: vec![], story: vec![] };
    let calls = 5 + importer.random.below(120);
    let outcome = (0..calls).try_for_each(|_| importer.call());
    importer.leave();
    outcome?;
    let stepped = importer.story.contains(&("DoStep", 0));
    Ok(if stepped { Fate::Taken } else { Fate::Refused })
}

unsafe extern "C" fn silent(_: *mut c_void, _: *const c_char, _: c_int, _: *const c_char, _: *const c_char) {}

/// Text, null, or bytes that are none.
fn text(random: &mut Random, good: &str) -> Option<CString> {
    match random.below(12) {
        0 => None,
        1 => CString::new(vec![0xff, 0xfe, b'%', b's']).ok(),
        2 => CString::new("").ok(),
        3 => CString::new("%n%s/../../\u{1F980}").ok(),
        _ => CString::new(good).ok(),
    }
}

fn at(text: Option<&CString>) -> *const c_char {
    text.map_or(null(), |text| text.as_ptr())
}

impl Importer<'_> {
    fn call(&mut self) -> Result<(), String> {
        if self.instances.is_empty() || (self.instances.len() < INSTANCES && self.random.once_in(30)) {
            self.instantiate();
            return Ok(());
        }
        let which = self.random.below(self.instances.len());
        let c = if self.random.once_in(200) { null_mut() } else { self.instances[which] };
        if self.random.once_in(60) {
            self.free(which);
            return Ok(());
        }
        let (name, status) = match self.random.below(16) {
            0..=2 => self.step(c),
            3 | 4 => self.proceed(c),
            5..=7 => self.get(c),
            8..=10 => self.set(c),
            11 | 12 => self.state(c),
            13 => self.bytes(c),
            14 => self.ask(c),
            _ => self.derivatives(c),
        };
        self.story.push((name, status));
        if status == FATAL || !(0..=FATAL).contains(&status) {
            let late = self.story.len().saturating_sub(12);
            return Err(format!("{name} returned {status} after {:?}", &self.story[late..]));
        }
        Ok(())
    }

    fn instantiate(&mut self) {
        let random = &mut self.random;
        let [guid, uri] = self.stage.identity();
        let (name, guid, uri) = (text(random, "gel"), text(random, guid), text(random, uri));
        let kind = if random.once_in(20) { random.bits() as c_int } else { 1 };
        let silent = silent as *const ();
        let callbacks = CallbackFunctions {
            // SAFETY: on the platforms of the tests, fixed arguments are passed alike with and without an ellipsis.
            logger: (!random.once_in(3)).then(|| unsafe { std::mem::transmute::<*const (), LoggerCallback>(silent) }),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            environment: null_mut(),
        };
        let functions = if random.once_in(40) { null() } else { &raw const callbacks };
        let debug = random.integer(2);
        // SAFETY: text or null each.
        let c = unsafe {
            fmi2Instantiate(at(name.as_ref()), kind, at(guid.as_ref()), at(uri.as_ref()), functions, 0, debug)
        };
        if !c.is_null() {
            self.instances.push(c);
            if !self.random.once_in(3) {
                self.begin(c);
            }
        }
    }

    /// Into the middle of an ordinary life, with one of the scenes.
    fn begin(&mut self, c: *mut c_void) {
        let path = self.random.pick(&self.stage.scenes).display().to_string();
        let scene = CString::new(path).expect("a path without null bytes");
        if self.random.once_in(2) {
            self.set(c);
        }
        // SAFETY: a live component, one reference and one text.
        unsafe {
            fmi2SetString(c, &reference("scene"), 1, &scene.as_ptr());
            fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0);
            fmi2EnterInitializationMode(c);
            fmi2ExitInitializationMode(c);
        }
    }

    fn free(&mut self, which: usize) {
        let c = self.instances.swap_remove(which);
        self.story.push(("FreeInstance", 0));
        // SAFETY: a live component, forgotten above.
        unsafe { fmi2FreeInstance(c) };
    }

    /// The next call of an ordinary life, or another of that kind.
    fn proceed(&mut self, c: *mut c_void) -> (&'static str, c_int) {
        let random = &mut self.random;
        let odd = random.once_in(8);
        let (start, stop) = if odd { (random.real(), random.real()) } else { (0.0, 1.0) };
        // SAFETY: a live component or null.
        unsafe {
            match random.below(if odd { 6 } else { 3 }) {
                0 => ("SetupExperiment", fmi2SetupExperiment(c, 0, 0.0, start, c_int::from(odd), stop)),
                1 => ("EnterInitializationMode", fmi2EnterInitializationMode(c)),
                2 => ("ExitInitializationMode", fmi2ExitInitializationMode(c)),
                3 => ("Terminate", fmi2Terminate(c)),
                4 => ("Reset", fmi2Reset(c)),
                _ => ("CancelStep", fmi2CancelStep(c)),
            }
        }
    }

    fn step(&mut self, c: *mut c_void) -> (&'static str, c_int) {
        let (mut now, mut smallest) = (0.0, 0.0);
        // SAFETY: one value and one reference each.
        unsafe {
            fmi2GetRealStatus(c, 2, &raw mut now);
            fmi2GetReal(c, &reference("cost.smallest_step"), 1, &raw mut smallest);
        }
        let random = &mut self.random;
        let length = match random.below(12) {
            0 => Some(random.real()).filter(|h| !(h.abs() > 1e-9 && h.abs() < 1e25)).unwrap_or(f64::NAN),
            _ if smallest > 0.0 => smallest * random.factor().min(LONGEST),
            _ => 1e-7,
        };
        let from = if random.once_in(12) { random.real() } else { now };
        // SAFETY: a live component or null.
        ("DoStep", unsafe { fmi2DoStep(c, from, length, random.integer(2)) })
    }

    /// References: none, a few, some of nothing.
    fn references(&mut self) -> Vec<u32> {
        let n = self.random.below(7);
        let one = |_| match self.random.below(10) {
            0 => self.random.bits() as u32,
            1 => 10_000 + self.random.below(400) as u32,
            _ => *self.random.pick(&self.stage.references[..150]),
        };
        (0..n).map(one).collect()
    }

    fn get(&mut self, c: *mut c_void) -> (&'static str, c_int) {
        let references = self.references();
        let n = references.len();
        let vr = if self.random.once_in(15) { null() } else { references.as_ptr() };
        let nowhere = self.random.once_in(15);
        let (mut reals, mut integers, mut texts) = (vec![0.0; n], vec![0; n], vec![null(); n]);
        // SAFETY: arrays of n items, or null.
        unsafe {
            match self.random.below(5) {
                0 => ("GetInteger", fmi2GetInteger(c, vr, n, if nowhere { null_mut() } else { integers.as_mut_ptr() })),
                1 => ("GetBoolean", fmi2GetBoolean(c, vr, n, if nowhere { null_mut() } else { integers.as_mut_ptr() })),
                2 => ("GetString", fmi2GetString(c, vr, n, if nowhere { null_mut() } else { texts.as_mut_ptr() })),
                _ => ("GetReal", fmi2GetReal(c, vr, n, if nowhere { null_mut() } else { reals.as_mut_ptr() })),
            }
        }
    }

    fn set(&mut self, c: *mut c_void) -> (&'static str, c_int) {
        let references = self.references();
        let n = references.len();
        let vr = if self.random.once_in(15) { null() } else { references.as_ptr() };
        let nowhere = self.random.once_in(15);
        let reals: Vec<f64> = (0..n).map(|_| self.random.real()).collect();
        // SAFETY: arrays of n items, or null; texts end with a null byte.
        unsafe {
            match self.random.below(6) {
                0 => {
                    let threads = [0, 1, 2, 5, -1, 1025, c_int::MAX, c_int::MIN];
                    let values: Vec<c_int> = (0..n.max(1)).map(|_| *self.random.pick(&threads)).collect();
                    let known = [*self.random.pick(&[11, 13, 323, 7])];
                    let (vr, n) = if self.random.once_in(2) { (known.as_ptr(), 1) } else { (vr, n) };
                    ("SetInteger", fmi2SetInteger(c, vr, n, if nowhere { null() } else { values.as_ptr() }))
                }
                1 => {
                    let values: Vec<c_int> = (0..n.max(1)).map(|_| self.random.bits() as c_int).collect();
                    let active = [reference("projectile.active")];
                    let (vr, n) = if self.random.once_in(2) { (active.as_ptr(), 1) } else { (vr, n) };
                    ("SetBoolean", fmi2SetBoolean(c, vr, n, if nowhere { null() } else { values.as_ptr() }))
                }
                2 => self.set_text(c),
                _ => ("SetReal", fmi2SetReal(c, vr, n, if nowhere { null() } else { reals.as_ptr() })),
            }
        }
    }

    fn set_text(&mut self, c: *mut c_void) -> (&'static str, c_int) {
        let stage = self.stage;
        let own = stage.path().join(format!("out{}", self.random.below(100_000)));
        let good = match self.random.below(4) {
            0 => own.display().to_string(),
            1 => (*self.random.pick(&["/dev/full/x", "/proc/none", "relative", "/dev/null"])).to_owned(),
            _ => self.random.pick(&stage.scenes).display().to_string(),
        };
        let value = text(&mut self.random, &good);
        let reference = *self.random.pick(&[10, 10, 12, 11]);
        let n = usize::from(!self.random.once_in(20));
        // SAFETY: one reference and one text or null, or none of either.
        ("SetString", unsafe { fmi2SetString(c, &raw const reference, n, &at(value.as_ref())) })
    }

    fn state(&mut self, c: *mut c_void) -> (&'static str, c_int) {
        let mut words = [self.random.bits(); 8];
        let strange = self.random.once_in(20);
        let known = self.random.below(self.states.len() + 1);
        // SAFETY: states of living memory, null, or words that are no state.
        unsafe {
            match self.random.below(3) {
                0 => {
                    let mut to = self.states.get(known).copied().unwrap_or(null_mut());
                    let status = fmi2GetFMUstate(c, &raw mut to);
                    if status == 0 && known == self.states.len() {
                        self.states.push(to);
                    }
                    ("GetFMUstate", status)
                }
                1 if strange => ("SetFMUstate", fmi2SetFMUstate(c, words.as_mut_ptr().cast())),
                1 => {
                    let from = self.states.get(known).copied().unwrap_or(null_mut());
                    ("SetFMUstate", fmi2SetFMUstate(c, from))
                }
                _ if known == self.states.len() => ("FreeFMUstate", fmi2FreeFMUstate(c, null_mut())),
                _ => {
                    let status = fmi2FreeFMUstate(c, &raw mut self.states[known]);
                    if self.states[known].is_null() {
                        self.states.swap_remove(known);
                    }
                    ("FreeFMUstate", status)
                }
            }
        }
    }

    /// The first state through bytes, damaged now and then.
    fn bytes(&mut self, c: *mut c_void) -> (&'static str, c_int) {
        let Some(&state) = self.states.first() else { return ("SerializedFMUstateSize", 0) };
        let mut size = 0;
        // SAFETY: a state, buffers of the sizes given.
        unsafe {
            let status = fmi2SerializedFMUstateSize(c, state, &raw mut size);
            if status != 0 {
                return ("SerializedFMUstateSize", status);
            }
            let mut bytes = vec![0; size + self.random.below(2)];
            let status = fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), bytes.len());
            if status != 0 {
                return ("SerializeFMUstate", status);
            }
            if self.random.once_in(3) {
                let at = self.random.below(bytes.len());
                bytes[at] ^= 1 << self.random.below(8);
            }
            let mut made = null_mut();
            let status = fmi2DeSerializeFMUstate(c, bytes.as_ptr(), bytes.len(), &raw mut made);
            if !made.is_null() {
                self.states.push(made);
            }
            ("DeSerializeFMUstate", status)
        }
    }

    fn ask(&mut self, c: *mut c_void) -> (&'static str, c_int) {
        let kind = self.random.integer(6) - 1;
        let (mut real, mut integer, mut answer) = (0.0, 0, null());
        let categories = [c"logEvents".as_ptr(), if self.random.once_in(4) { null() } else { c"none".as_ptr() }];
        // SAFETY: one value each; as many texts as are said to be there.
        unsafe {
            match self.random.below(6) {
                0 => ("GetStatus", fmi2GetStatus(c, kind, &raw mut integer)),
                1 => ("GetRealStatus", fmi2GetRealStatus(c, kind, if kind < 0 { null_mut() } else { &raw mut real })),
                2 => ("GetIntegerStatus", fmi2GetIntegerStatus(c, kind, &raw mut integer)),
                3 => ("GetBooleanStatus", fmi2GetBooleanStatus(c, kind, &raw mut integer)),
                4 => ("GetStringStatus", fmi2GetStringStatus(c, kind, &raw mut answer)),
                _ => ("SetDebugLogging", fmi2SetDebugLogging(c, kind, self.random.below(3), categories.as_ptr())),
            }
        }
    }

    fn derivatives(&mut self, c: *mut c_void) -> (&'static str, c_int) {
        let (references, known) = (self.references(), self.references());
        let n = references.len();
        let orders: Vec<c_int> = (0..n).map(|_| self.random.integer(3)).collect();
        let reals: Vec<f64> = (0..n.max(known.len())).map(|_| self.random.real()).collect();
        let mut out = vec![0.0; n];
        let vr = if self.random.once_in(15) { null() } else { references.as_ptr() };
        // SAFETY: arrays of the lengths given, or null.
        unsafe {
            match self.random.below(3) {
                0 => ("SetRealInputDerivatives", {
                    fmi2SetRealInputDerivatives(c, vr, n, orders.as_ptr(), reals.as_ptr())
                }),
                1 => ("GetRealOutputDerivatives", {
                    fmi2GetRealOutputDerivatives(c, vr, n, orders.as_ptr(), out.as_mut_ptr())
                }),
                _ => ("GetDirectionalDerivative", {
                    let (to, seeds) = (out.as_mut_ptr(), reals.as_ptr());
                    fmi2GetDirectionalDerivative(c, vr, n, known.as_ptr(), known.len(), seeds, to)
                }),
            }
        }
    }

    /// Gives everything back.
    fn leave(&mut self) {
        let archive = &self.stage.archive;
        let callbacks = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            environment: null_mut(),
        };
        // SAFETY: states are freed once, by an instance that was made for it; then all instances.
        unsafe {
            let (guid, uri) = (archive.guid.as_ptr(), archive.uri.as_ptr());
            let c = fmi2Instantiate(c"last".as_ptr(), 1, guid, uri, &raw const callbacks, 0, 0);
            for mut state in self.states.drain(..) {
                fmi2FreeFMUstate(c, &raw mut state);
            }
            self.instances.drain(..).for_each(|c| fmi2FreeInstance(c));
            fmi2FreeInstance(c);
        }
    }
}
