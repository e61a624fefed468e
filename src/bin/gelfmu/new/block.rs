//! Size of a block of gel, as given on the command line, and the part of it that is meshed.

use ballistic_gel::scene::QuantityKind;

/// Width, height and length of a block, m; the projectile flies along the length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockSize {
    /// Width, m.
    pub width: f64,
    /// Height, m.
    pub height: f64,
    /// Length along the path, m.
    pub length: f64,
}

/// Part of the gel that is meshed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshedPart {
    /// Meridian plane of a cylinder.
    Meridian,
    /// Quarter of a block, between two planes of symmetry.
    Quarter,
    /// Half of a block, on one side of the plane of the yaw.
    Half,
    /// Whole block.
    Whole,
}

impl BlockSize {
    /// Parses three lengths such as `15x15x40cm`; the unit of the last one holds for those without a unit.
    pub fn parse(text: &str) -> Result<Self, String> {
        let expected = || format!("found {text:?}, expected three lengths such as 15x15x40cm or 0.15x0.15x0.4 (m)");
        let text = text.replace('"', "in");
        let parts: Vec<&str> = text.split(['x', '×', '*']).map(str::trim).collect();
        let [width, height, length] = parts[..] else { return Err(expected()) };
        let has_unit = |part: &&str| part.ends_with(|c: char| c.is_alphabetic());
        if has_unit(&width) != has_unit(&length) && !has_unit(&length) || has_unit(&height) && !has_unit(&length) {
            return Err(expected());
        }
        let unit = length.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').trim();
        let metres = |part: &str| {
            let text = if has_unit(&part) { part.to_owned() } else { format!("{part} {unit}").trim().to_owned() };
            let value = QuantityKind::Length.parse(&text).map_err(|_| expected())?;
            let too_large =
                || format!("found {text:?}, a block of more than 3 m; expected a unit, such as in 15x15x40cm");
            match value {
                _ if value > 3.0 => Err(too_large()),
                _ if value >= 1e-3 => Ok(value),
                _ => Err(expected()),
            }
        };
        Ok(Self { width: metres(width)?, height: metres(height)?, length: metres(length)? })
    }

    /// Radius of the cylinder with the cross-section of the block, m.
    pub fn equivalent_radius(self) -> f64 {
        (self.width * self.height / std::f64::consts::PI).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::BlockSize;

    #[test]
    fn one_unit_holds_for_all_lengths_of_a_block() {
        let block = |width, height, length| Ok(BlockSize { width, height, length });
        assert_eq!(BlockSize::parse("15x15x40cm"), block(0.15, 0.15, 0.4));
        assert_eq!(BlockSize::parse("15 x 20 x 40 cm"), block(0.15, 0.2, 0.4));
        assert_eq!(BlockSize::parse("0.15x0.15x0.4"), block(0.15, 0.15, 0.4));
        assert_eq!(BlockSize::parse("6inx6inx16in"), block(0.1524, 0.1524, 0.4064));
        assert_eq!(BlockSize::parse("6\"x6\"x16\""), block(0.1524, 0.1524, 0.4064));
        for text in ["15x15cm", "15x15x40kg", "axbxc", "0x15x40cm", "", "15x15x", "15x15x40", "15cmx15cmx40"] {
            assert!(BlockSize::parse(text).is_err(), "{text}");
        }
    }
}
