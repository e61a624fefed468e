//! Built-in scenes.

const BUILTINS: [(&str, &str); 16] = [
    ("fbi-bb", include_str!("../../scenes/fbi-bb.toml")),
    ("fbi-bb-3d", include_str!("../../scenes/fbi-bb-3d.toml")),
    ("sphere-720", include_str!("../../scenes/sphere-720.toml")),
    ("bullet-yaw", include_str!("../../scenes/bullet-yaw.toml")),
    ("hydro-drag", include_str!("../../scenes/hydro-drag.toml")),
    ("sphere-block", include_str!("../../scenes/sphere-block.toml")),
    ("sphere-deep", include_str!("../../scenes/sphere-deep.toml")),
    ("ball-bounce", include_str!("../../scenes/ball-bounce.toml")),
    ("bounce-visco", include_str!("../../scenes/bounce-visco.toml")),
    ("backface-dent", include_str!("../../scenes/backface-dent.toml")),
    ("cavity-exact", include_str!("../../scenes/cavity-exact.toml")),
    ("ball-square", include_str!("../../scenes/ball-square.toml")),
    ("l-beam", include_str!("../../scenes/l-beam.toml")),
    ("sphere-graded-4", include_str!("../../scenes/sphere-graded-4.toml")),
    ("sphere-graded-8", include_str!("../../scenes/sphere-graded-8.toml")),
    ("sphere-graded-16", include_str!("../../scenes/sphere-graded-16.toml")),
];

/// Text of a built-in scene.
#[must_use]
pub fn builtin(name: &str) -> Option<&'static str> {
    builtins().find(|(known, _)| *known == name).map(|(_, text)| text)
}

/// Names and texts of all built-in scenes; the first is the default.
pub fn builtins() -> impl Iterator<Item = (&'static str, &'static str)> {
    BUILTINS.into_iter()
}

#[cfg(test)]
mod tests {
    use super::builtins;
    use crate::scene::read;

    #[test]
    fn every_builtin_scene_reads_and_carries_its_own_name() {
        for (name, text) in builtins() {
            let scene = read(text).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(scene.scene.name, name);
            assert!(!scene.scene.title.is_empty(), "{name} has no title");
        }
    }
}
