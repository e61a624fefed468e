//! A minimal importer: one instance, its log, and checked calls of the exported functions.

use ballistic_gel::fmi2::abi::*;
use ballistic_gel::fmi2::{ArchiveContent, ArchiveManifest, CallbackFunctions, VariablePorts};
use ballistic_gel::scene;
use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr;
use tempfile::TempDir;

pub const OK: c_int = 0;
pub const WARNING: c_int = 1;
pub const DISCARD: c_int = 2;
pub const ERROR: c_int = 3;

/// A line of log: status, category, text.
pub type Line = (c_int, String, String);

/// One instance with the folder of its resources, if it was made of them.
pub struct Host {
    pub c: *mut c_void,
    #[allow(clippy::box_collection)] // its address is handed out
    log: Box<Vec<Line>>,
    folder: Option<TempDir>,
}

/// What `fmi2Instantiate` is called with.
#[derive(Clone, Copy)]
pub struct Made<'a> {
    pub name: Option<&'a CStr>,
    pub fmu_type: c_int,
    pub guid: Option<&'a CStr>,
    pub resources: Option<&'a CStr>,
}

unsafe extern "C" fn keep(
    environment: *mut c_void,
    _name: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the log of a `Host`; the texts end with a null byte.
    unsafe {
        let text = |at| CStr::from_ptr(at).to_str().unwrap().to_owned();
        (*environment.cast::<Vec<Line>>()).push((status, text(category), text(message)));
    }
}

/// The callbacks of an importer that keeps the log in `log`.
pub fn callbacks(log: &mut Vec<Line>) -> CallbackFunctions {
    let keep = keep as *const ();
    CallbackFunctions {
        // SAFETY: on the platforms of the tests, fixed arguments are passed alike with and without an ellipsis.
        logger: Some(unsafe { std::mem::transmute::<*const (), LoggerCallback>(keep) }),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        environment: ptr::from_mut(log).cast(),
    }
}

/// A coarse and therefore quick `sphere-block`.
pub fn coarse() -> String {
    scene::builtin("sphere-block").unwrap().replace("size = 5e-3", "size = 10e-3")
}

/// Value reference of `name` or `name[i]`.
pub fn reference(name: &str) -> u32 {
    VariablePorts::all().scalars().find(|scalar| scalar.name() == name).expect(name).reference()
}

/// The folder `resources/` of an archive with this scene and these files beside it.
pub struct Resources {
    pub folder: TempDir,
    /// Its URI.
    pub uri: CString,
    /// GUID of the archive.
    pub guid: CString,
}

impl Resources {
    /// Packs them as `gelfmu pack` does, with the manifest.
    pub fn packed(scene: &str, files: &[(&str, &[u8])]) -> Self {
        let all = files.iter().copied().chain([("scene.toml", scene.as_bytes())]);
        let all: BTreeMap<String, Vec<u8>> = all.map(|(name, bytes)| (name.to_owned(), bytes.to_vec())).collect();
        let manifest =
            ArchiveManifest::of(&ArchiveContent { description: "", libraries: &BTreeMap::new(), resources: &all });
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in &all {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        std::fs::write(folder.path().join(ArchiveManifest::FILE), manifest.to_json()).unwrap();
        let uri = CString::new(format!("file://{}", folder.path().display())).unwrap();
        Self { folder, uri, guid: CString::new(manifest.guid()).unwrap() }
    }

    /// Arguments of `fmi2Instantiate` that are taken.
    pub fn arguments(&self) -> Made<'_> {
        Made { name: Some(c"gel"), fmu_type: 1, guid: Some(&self.guid), resources: Some(&self.uri) }
    }
}

impl Host {
    /// An instance with this text as `resources/scene.toml`.
    pub fn with(scene: &str) -> Self {
        Self::of(Resources::packed(scene, &[]))
    }

    /// An instance of an archive.
    pub fn of(archive: Resources) -> Self {
        let mut host = Self::made(&archive.arguments());
        assert!(!host.c.is_null(), "{:?}", host.log);
        host.folder = Some(archive.folder);
        host
    }

    /// What comes of the arguments; a null component if they are refused.
    pub fn made(made: &Made<'_>) -> Self {
        let mut log = Box::new(Vec::new());
        let callbacks = callbacks(&mut log);
        let at = |text: Option<&CStr>| text.map_or(ptr::null(), CStr::as_ptr);
        let (name, guid, resources) = (at(made.name), at(made.guid), at(made.resources));
        // SAFETY: text or null each.
        let c = unsafe { fmi2Instantiate(name, made.fmu_type, guid, resources, &raw const callbacks, 0, 0) };
        Self { c, log, folder: None }
    }

    /// The coarse scene, after initialization from 0 s on.
    pub fn started() -> Self {
        let mut host = Self::with(&coarse());
        host.start();
        host
    }

    pub fn start(&mut self) {
        self.enter();
        // SAFETY: a live component.
        assert_eq!(unsafe { fmi2ExitInitializationMode(self.c) }, OK, "{:?}", self.log);
    }

    pub fn enter(&mut self) {
        // SAFETY: a live component.
        unsafe {
            assert_eq!(fmi2SetupExperiment(self.c, 0, 0.0, 0.0, 1, 0.01), OK);
            assert_eq!(fmi2EnterInitializationMode(self.c), OK);
        }
    }

    /// `n` steps of length `h`, s, from `from` on.
    pub fn steps(&mut self, from: f64, h: f64, n: u32) {
        for k in 0..n {
            // SAFETY: a live component.
            let status = unsafe { fmi2DoStep(self.c, from + f64::from(k) * h, h, 0) };
            assert_eq!(status, OK, "{:?}", self.log);
        }
    }

    pub fn set(&mut self, name: &str, value: f64) -> c_int {
        // SAFETY: one reference and one value.
        unsafe { fmi2SetReal(self.c, &reference(name), 1, &raw const value) }
    }

    pub fn set_integer(&mut self, name: &str, value: c_int) -> c_int {
        // SAFETY: one reference and one value.
        unsafe { fmi2SetInteger(self.c, &reference(name), 1, &raw const value) }
    }

    pub fn set_text(&mut self, name: &str, value: &Path) -> c_int {
        let text = CString::new(value.to_str().unwrap()).unwrap();
        // SAFETY: one reference and one text.
        unsafe { fmi2SetString(self.c, &reference(name), 1, &text.as_ptr()) }
    }

    pub fn get(&mut self, name: &str) -> f64 {
        let mut value = f64::NAN;
        // SAFETY: one reference and one value.
        let status = unsafe { fmi2GetReal(self.c, &reference(name), 1, &raw mut value) };
        assert_eq!(status, OK, "{name}: {:?}", self.log);
        value
    }

    pub fn integer(&mut self, name: &str) -> c_int {
        let mut value = 0;
        // SAFETY: one reference and one value.
        let status = unsafe { fmi2GetInteger(self.c, &reference(name), 1, &raw mut value) };
        assert_eq!(status, OK, "{name}: {:?}", self.log);
        value
    }

    /// Every Real, bit by bit.
    pub fn bits(&mut self) -> Vec<u64> {
        let names: Vec<String> = VariablePorts::all()
            .limited_to(0, 0)
            .scalars()
            .filter(|s| s.variable.unit.is_some())
            .map(|s| s.name())
            .collect();
        names.iter().map(|name| self.get(name).to_bits()).collect()
    }

    pub fn state(&mut self) -> *mut c_void {
        let mut state = ptr::null_mut();
        // SAFETY: a pointer to a null pointer.
        assert_eq!(unsafe { fmi2GetFMUstate(self.c, &raw mut state) }, OK);
        state
    }

    pub fn bytes(&mut self) -> Vec<u8> {
        let mut state = self.state();
        let mut size = 0;
        // SAFETY: a state of this FMU, and a buffer of its size.
        unsafe {
            assert_eq!(fmi2SerializedFMUstateSize(self.c, state, &raw mut size), OK);
            let mut bytes = vec![0; size];
            assert_eq!(fmi2SerializeFMUstate(self.c, state, bytes.as_mut_ptr(), size), OK);
            assert_eq!(fmi2FreeFMUstate(self.c, &raw mut state), OK);
            bytes
        }
    }

    /// Goes to serialised bytes: the worse status of making a state of them and of setting it.
    pub fn restore(&mut self, bytes: &[u8]) -> c_int {
        let mut state = ptr::null_mut();
        // SAFETY: bytes of the length given, and a pointer to a null pointer.
        unsafe {
            let made = fmi2DeSerializeFMUstate(self.c, bytes.as_ptr(), bytes.len(), &raw mut state);
            if made != OK {
                return made;
            }
            let status = fmi2SetFMUstate(self.c, state);
            assert_eq!(fmi2FreeFMUstate(self.c, &raw mut state), OK);
            status
        }
    }

    /// Hash of the simulation, as it stands in the serialised state.
    pub fn digest(&mut self) -> [u8; 16] {
        self.bytes()[12..28].try_into().unwrap()
    }

    /// The lines since the last call.
    pub fn lines(&mut self) -> Vec<Line> {
        std::mem::take(&mut self.log)
    }

    /// The one line that the last call logged.
    pub fn one_line(&mut self) -> String {
        let lines = self.lines();
        assert_eq!(lines.len(), 1, "{lines:?}");
        lines.into_iter().next().unwrap().2
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.as_ref().unwrap().path().join(name)
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: a live component, or null.
        unsafe { fmi2FreeInstance(self.c) };
    }
}
