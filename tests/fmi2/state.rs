//! States: back, on, into another instance, as bytes, and what is refused.

use super::host::{DISCARD, ERROR, Host, OK, coarse};
use ballistic_gel::fmi2::abi::*;
use ballistic_gel::scene;
use std::ffi::c_void;
use std::ptr;

#[test]
fn going_back_and_on_again_gives_the_same_bits() {
    let mut host = Host::started();
    host.steps(0.0, 1e-4, 5);
    let mut state = host.state();
    let there = host.bits();
    host.steps(5e-4, 1e-4, 5);
    let end = host.bits();
    assert_ne!(there, end);
    assert_eq!(unsafe { fmi2SetFMUstate(host.c, state) }, OK);
    assert_eq!(host.bits(), there);
    host.steps(5e-4, 1e-4, 5);
    assert_eq!(host.bits(), end);
    assert_eq!(unsafe { fmi2FreeFMUstate(host.c, &raw mut state) }, OK);
    assert!(state.is_null());
}

#[test]
fn bytes_restore_an_instance_that_was_merely_made() {
    let mut host = Host::with(&coarse());
    assert_eq!(host.set("gel.shear_modulus", 5e4), OK);
    host.start();
    host.steps(0.0, 1e-4, 5);
    let bytes = host.bytes();
    let mut other = Host::with("this is no scene");
    assert_eq!(other.restore(&bytes), OK, "{:?}", other.lines());
    assert_eq!(other.bytes(), bytes);
    host.steps(5e-4, 1e-4, 5);
    other.steps(5e-4, 1e-4, 5);
    assert_eq!(other.bits(), host.bits());
    assert_eq!(other.bytes(), host.bytes());
}

#[test]
fn threads_are_no_part_of_the_state_and_change_no_bit() {
    let mut one = Host::started();
    let mut two = Host::with(&coarse());
    assert_eq!(two.set_integer("threads", 2), OK);
    two.start();
    one.steps(0.0, 1e-4, 5);
    two.steps(0.0, 1e-4, 5);
    assert_eq!(one.bytes(), two.bytes());
}

#[test]
fn the_communication_step_leaves_no_trace() {
    let mut digests = [(1e-3, 1), (1e-4, 10), (1e-3 / 64.0, 64)].map(|(h, n)| {
        let mut host = Host::started();
        host.steps(0.0, h, n);
        host.digest()
    });
    assert_eq!(digests[0], digests[1]);
    assert_eq!(digests[0], digests[2]);
    let mut host = Host::with(&coarse());
    host.set("projectile.mass", 0.0331);
    host.start();
    host.steps(0.0, 1e-3, 1);
    digests[0] = host.digest();
    assert_ne!(digests[0], digests[1]);
}

#[test]
fn a_failed_instance_fails_again_also_where_it_is_restored() {
    let mut host = super::order::failed();
    let text = host.one_line();
    assert!(text.contains("element") || text.contains("leaks"), "{text}");
    assert!(text.starts_with("the simulation has stopped (times since its start): "), "{text}");
    assert_eq!(text.matches(" s:").count(), 1, "one time only: {text}");
    let bytes = host.bytes();
    let mut other = Host::with(&coarse());
    assert_eq!(other.restore(&bytes), OK);
    for host in [&mut host, &mut other] {
        let now = host.get("time");
        let begun = (now / 1e-6).floor() * 1e-6;
        for (at, step) in [(begun, 1e-6), (begun + 1e-6, 1e-6), (now, 1e-6), (now, 1.0), (0.0, 1e-9)] {
            assert_eq!(unsafe { fmi2DoStep(host.c, at, step, 0) }, DISCARD, "step {step} at {at}");
            assert_eq!(host.one_line(), text);
        }
        assert_eq!(stopped(host), 1);
        assert_eq!(unsafe { fmi2Terminate(host.c) }, OK);
        assert_eq!(stopped(host), 1, "also after it was terminated");
        assert_eq!(unsafe { fmi2Reset(host.c) }, OK);
    }
}

fn stopped(host: &Host) -> i32 {
    let mut stopped = 7;
    assert_eq!(unsafe { fmi2GetBooleanStatus(host.c, 3, &raw mut stopped) }, OK);
    stopped
}

#[test]
fn a_state_pointer_is_used_again() {
    let mut host = Host::started();
    let mut state = host.state();
    let kept = state;
    host.steps(0.0, 1e-4, 1);
    let now = host.bits();
    assert_eq!(unsafe { fmi2GetFMUstate(host.c, &raw mut state) }, OK);
    assert_eq!(state, kept);
    host.steps(1e-4, 1e-4, 1);
    assert_eq!(unsafe { fmi2SetFMUstate(host.c, state) }, OK);
    assert_eq!(host.bits(), now);
    assert_eq!(unsafe { fmi2FreeFMUstate(host.c, &raw mut state) }, OK);
}

#[test]
fn damaged_bytes_are_refused_and_harm_nothing() {
    let mut host = Host::started();
    host.steps(0.0, 1e-4, 1);
    let bytes = host.bytes();
    let bits = host.bits();
    for at in (0..bytes.len()).step_by(bytes.len() / 200) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        assert_eq!(host.restore(&damaged), ERROR, "byte {at}");
        assert_eq!(host.restore(&bytes[..at]), ERROR, "cut off at {at}");
        assert_eq!(host.lines().len(), 2);
    }
    assert_eq!(host.restore(b""), ERROR);
    assert_eq!(host.restore(&[7; 4096]), ERROR);
    assert_eq!(host.bits(), bits);
    host.steps(1e-4, 1e-4, 1);
}

#[test]
fn bytes_that_are_refused_leave_the_state_behind_the_pointer() {
    let mut host = Host::started();
    host.steps(0.0, 1e-4, 1);
    let (bits, mut early) = (host.bits(), host.state());
    host.steps(1e-4, 1e-4, 1);
    let (later, mut bytes) = (host.bits(), host.bytes());
    let middle = bytes.len() / 2;
    let kept = early;
    let into = |host: &Host, bytes: &[u8], state: &mut *mut c_void| unsafe {
        fmi2DeSerializeFMUstate(host.c, bytes.as_ptr(), bytes.len(), state)
    };
    bytes[middle] ^= 1;
    assert_eq!(into(&host, &bytes, &mut early), ERROR);
    assert_eq!(unsafe { fmi2SetFMUstate(host.c, early) }, OK);
    assert_eq!(host.bits(), bits);
    bytes[middle] ^= 1;
    assert_eq!(into(&host, &bytes, &mut early), OK);
    assert_eq!(early, kept);
    assert_eq!(unsafe { fmi2SetFMUstate(host.c, early) }, OK);
    assert_eq!(host.bits(), later);
    assert_eq!(unsafe { fmi2FreeFMUstate(host.c, &raw mut early) }, OK);
}

#[test]
fn a_state_pointer_follows_the_instance_to_another_scene_and_back() {
    let mut host = Host::started();
    let mut state = host.state();
    let solid = host.bytes();
    assert_eq!(unsafe { fmi2Reset(host.c) }, OK);
    assert_eq!(unsafe { fmi2GetFMUstate(host.c, &raw mut state) }, OK);
    assert_eq!(unsafe { fmi2SetFMUstate(host.c, state) }, OK, "a state without a simulation");
    let planar = host.path("planar.toml");
    std::fs::write(&planar, scene::builtin("ball-square").unwrap()).unwrap();
    assert_eq!(host.set_text("scene", &planar), OK);
    host.start();
    host.steps(0.0, 1e-4, 1);
    let bits = host.bits();
    assert_eq!(unsafe { fmi2GetFMUstate(host.c, &raw mut state) }, OK);
    assert_eq!(host.restore(&solid), OK, "{:?}", host.lines());
    assert_ne!(host.bits(), bits);
    assert_eq!(unsafe { fmi2SetFMUstate(host.c, state) }, OK);
    assert_eq!(host.bits(), bits);
    assert_eq!(unsafe { fmi2FreeFMUstate(host.c, &raw mut state) }, OK);
}

#[test]
fn reading_outputs_does_not_change_later_outputs() {
    let mut all = Host::started();
    let mut last = Host::started();
    for k in 0..5 {
        all.bits();
        all.steps(f64::from(k) * 1e-3, 1e-3, 1);
        last.steps(f64::from(k) * 1e-3, 1e-3, 1);
    }
    assert!(last.get("contact.total_impulse[3]") > 0.0);
    assert_eq!(all.bits(), last.bits());
    let mut state = all.state();
    all.steps(5e-3, 1e-3, 1);
    let on = all.bits();
    assert_eq!(unsafe { fmi2SetFMUstate(all.c, state) }, OK);
    assert_eq!(all.bits(), last.bits());
    assert_ne!(all.bits(), on);
    assert_eq!(unsafe { fmi2FreeFMUstate(all.c, &raw mut state) }, OK);
}

#[test]
fn a_pointer_that_is_no_state_is_refused() {
    let mut host = Host::started();
    let mut words = [0_u64; 8];
    let foreign: *mut c_void = words.as_mut_ptr().cast();
    assert_eq!(unsafe { fmi2SetFMUstate(host.c, foreign) }, ERROR);
    assert!(host.one_line().contains("not a state of this FMU"));
    let mut target = foreign;
    assert_eq!(unsafe { fmi2GetFMUstate(host.c, &raw mut target) }, ERROR);
    assert_eq!(unsafe { fmi2FreeFMUstate(host.c, &raw mut target) }, ERROR);
    assert_eq!(words, [0; 8]);
}

#[test]
fn freeing_nothing_is_harmless_also_by_value() {
    let mut host = Host::started();
    let mut none: *mut c_void = ptr::null_mut();
    let mut state = host.state();
    unsafe {
        assert_eq!(fmi2FreeFMUstate(host.c, ptr::null_mut()), OK);
        assert_eq!(fmi2FreeFMUstate(host.c, &raw mut none), OK);
        assert_eq!(fmi2FreeFMUstate(host.c, state.cast()), OK);
        assert_eq!(fmi2SetFMUstate(host.c, state), OK, "the state is still there");
        assert_eq!(fmi2FreeFMUstate(host.c, &raw mut state), OK);
    }
}

#[test]
fn a_buffer_of_another_size_is_refused() {
    let mut host = Host::started();
    let mut state = host.state();
    let mut buffer = vec![0; 10];
    unsafe {
        assert_eq!(fmi2SerializeFMUstate(host.c, state, buffer.as_mut_ptr(), 10), ERROR);
        assert_eq!(fmi2FreeFMUstate(host.c, &raw mut state), OK);
    }
    assert!(host.one_line().contains("10 bytes"));
}
