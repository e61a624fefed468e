//! Runs of the driven importer in which one request for memory is refused, and how each ended.

use super::shim;
use ballistic_gel::fmi2::{ArchiveContent, ArchiveManifest};
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use tempfile::TempDir;

/// A refusal of memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Refusal {
    /// Number of the request.
    pub request: i64,
    /// Whether from then on everything is refused that would add to what is held.
    pub is_limit: bool,
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    Completed,
    Refused(String),
    /// Aborted for want of so many bytes.
    Aborted(u64),
    Crashed(String),
}

/// A request for memory of the run without refusals.
#[derive(Debug, Clone, Copy)]
pub struct Request {
    pub bytes: u64,
    /// Hash of the frames of its call.
    pub site: u64,
}

/// A run without refusals: its requests by number, and the frames of each site.
pub struct Profile {
    pub requests: Vec<Request>,
    pub frames: BTreeMap<u64, Vec<u64>>,
}

/// A scene, and the shim to run it with.
pub struct Stage {
    folder: TempDir,
    shim: PathBuf,
    /// Whether its runs write results.
    writes: bool,
    n_runs: AtomicUsize,
}

impl Stage {
    /// `None` where there is no C compiler, or no allocator that the shim stands in front of.
    pub fn new(scene: &str, writes: bool) -> Option<Self> {
        if !cfg!(all(target_os = "linux", target_env = "gnu")) {
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        let resources = BTreeMap::from([("scene.toml".to_owned(), scene.as_bytes().to_vec())]);
        let manifest = ArchiveManifest::of(&ArchiveContent {
            description: "",
            libraries: &BTreeMap::new(),
            resources: &resources,
        });
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        fs::write(folder.path().join(ArchiveManifest::FILE), manifest.to_json()).unwrap();
        let shim = shim::compiled(folder.path())?;
        Some(Self { folder, shim, writes, n_runs: AtomicUsize::new(0) })
    }

    /// The run without refusals.
    pub fn profile(&self) -> Profile {
        let file = self.folder.path().join("requests");
        let (outcome, text) = self.child(&format!("profile {}", file.display()));
        assert_eq!(outcome, Outcome::Completed, "{text}");
        let mut profile = Profile { requests: vec![], frames: BTreeMap::new() };
        let hex = |text: &str| u64::from_str_radix(text.trim_start_matches("0x"), 16).unwrap();
        for line in fs::read_to_string(&file).unwrap().lines() {
            let words: Vec<&str> = line.split(' ').collect();
            if let ["#", site, frames @ ..] = &words[..] {
                profile.frames.insert(hex(site), frames.iter().map(|frame| hex(frame)).collect());
            } else {
                profile.requests.push(Request { bytes: words[0].parse().unwrap(), site: hex(words[1]) });
            }
        }
        profile
    }

    /// The bytes by which most was held in each call.
    pub fn spent(&self) -> Vec<(String, u64)> {
        let (outcome, text) = self.child("measure");
        assert_eq!(outcome, Outcome::Completed, "{text}");
        let calls = text.lines().filter_map(|line| line.strip_prefix("SPENT ")?.split_once(' '));
        calls.map(|(name, bytes)| (name.to_owned(), bytes.parse().unwrap())).collect()
    }

    /// How the run ends with so many bytes of address space.
    pub fn outcome_in_space(&self, bytes: u64) -> Outcome {
        self.child(&format!("space {bytes}")).0
    }

    /// The words in which the scene is refused with so many bytes of address space.
    pub fn refusal_in_space(&self, bytes: u64) -> String {
        let (outcome, text) = self.child(&format!("beyond {bytes}"));
        let Outcome::Refused(words) = outcome else { panic!("{outcome:?}: {text}") };
        words
    }

    /// How the run with a refusal ends.
    pub fn outcome(&self, refusal: Refusal) -> Outcome {
        let kind = if refusal.is_limit { "limit" } else { "once" };
        self.child(&format!("{kind} {}", refusal.request)).0
    }

    fn child(&self, plan: &str) -> (Outcome, String) {
        let number = self.n_runs.fetch_add(1, Ordering::Relaxed).to_string();
        let results = if self.writes { self.folder.path().join(number) } else { PathBuf::new() };
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args(["--exact", "the_driven_importer", "--ignored", "--nocapture", "--test-threads=1"]);
        command.env("LD_PRELOAD", &self.shim).env("GEL_SHORTAGE_PLAN", plan);
        command.env("GEL_SHORTAGE_SCENE", self.folder.path()).env("GEL_SHORTAGE_RESULTS", &results);
        let output = command.output().unwrap();
        let _ = fs::remove_dir_all(&results);
        let (said, complained) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        let text = format!("{said}\n{complained}");
        let ending = text.lines().find_map(|line| line.split("ENDING ").nth(1)).map(str::to_owned);
        let wanted = complained.split("memory allocation of ").nth(1).and_then(|rest| rest.split(' ').next());
        let outcome = match (ending, wanted.and_then(|bytes| bytes.parse().ok())) {
            (Some(ending), _) if output.status.success() => match ending.strip_prefix("refused ") {
                Some(words) => Outcome::Refused(words.to_owned()),
                None => Outcome::Completed,
            },
            (_, Some(bytes)) => Outcome::Aborted(bytes),
            _ => Outcome::Crashed(format!("{}: {text}", output.status)),
        };
        (outcome, text)
    }

    /// The outcomes of many runs, on two threads, by refusal.
    pub fn outcomes(&self, refusals: &[Refusal]) -> Vec<(Refusal, Outcome)> {
        let (next, outcomes) = (AtomicUsize::new(0), Mutex::new(vec![]));
        std::thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(|| {
                    let mine = std::iter::from_fn(|| refusals.get(next.fetch_add(1, Ordering::Relaxed)));
                    mine.map(|refusal| (*refusal, self.outcome(*refusal)))
                        .for_each(|found| outcomes.lock().unwrap().push(found));
                });
            }
        });
        outcomes.into_inner().unwrap()
    }
}

impl Profile {
    /// Numbers of the requests of each site.
    pub fn sites(&self) -> BTreeMap<u64, Vec<i64>> {
        let mut sites = BTreeMap::<u64, Vec<i64>>::new();
        for (number, request) in (0..).zip(&self.requests) {
            sites.entry(request.site).or_default().push(number);
        }
        sites
    }

    /// The greatest request of each site, the largest first.
    pub fn largest(&self) -> Vec<(u64, u64)> {
        let mut greatest = BTreeMap::<u64, u64>::new();
        for request in &self.requests {
            let known = greatest.entry(request.site).or_default();
            *known = request.bytes.max(*known);
        }
        let mut sites: Vec<_> = greatest.into_iter().collect();
        sites.sort_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
        sites
    }

    /// The innermost functions of a site that are not of the standard library, if `addr2line` knows them.
    pub fn name(&self, site: u64) -> String {
        let frames = self.frames[&site].iter().map(|frame| format!("{:x}", frame.saturating_sub(1)));
        let mut command = Command::new("addr2line");
        command.args(["-f", "-C", "-i", "-e"]).arg(std::env::current_exe().unwrap()).args(frames);
        let Ok(output) = command.output() else { return format!("{:x?}", self.frames[&site]) };
        let of_library = |line: &&str| {
            let roots = ["alloc::", "core::", "std::", "hashbrown::", "<alloc::", "<core::", "__rust", "??"];
            !roots.iter().any(|root| line.starts_with(root)) && !line.contains("BackedAllocator")
        };
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let names = text.lines().step_by(2).filter(of_library).take(3);
        names.collect::<Vec<_>>().join(" < ")
    }
}
