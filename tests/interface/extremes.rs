//! The quick half of the table of extremes; the whole of it is `cargo run --release --manifest-path studies/Cargo.toml -- extremes`.

#[path = "../../studies/src/limits/mod.rs"]
#[allow(dead_code, reason = "the study runs the long half, too")]
mod limits;

#[test]
fn each_extreme_gives_what_is_known_beforehand_or_says_why_not() {
    let missed = limits::table(&limits::QUICK);
    assert!(missed.is_empty(), "{missed:#?}");
}
