//! Colour maps and PNG files.

/// Colour map: five equidistant colours, red, green and blue.
#[derive(Debug)]
pub(in crate::output) struct ColourMap([[u8; 3]; 5]);

/// Colour map of speeds: violet at rest, through rose, to yellow. Lightness grows with speed, also for colour-blind
/// eyes.
pub(in crate::output) const SPEED: ColourMap =
    ColourMap([[74, 60, 168], [146, 52, 172], [212, 78, 122], [246, 148, 66], [250, 240, 110]]);
/// Colour map of time steps: dark blue for small steps, through green, to pale yellow for large steps.
pub(in crate::output) const STEP: ColourMap =
    ColourMap([[28, 32, 92], [36, 92, 150], [40, 150, 140], [128, 200, 96], [244, 236, 150]]);
/// Colour of gel without a value, such as the time step of an element before its first update.
const UNKNOWN: [u8; 3] = [190, 190, 190];
/// Colour of gelatin.
pub(in crate::output) const AMBER: [u8; 3] = [240, 178, 74];

impl ColourMap {
    /// Returns the colour at a place, 0 to 1; grey for a place that is not finite.
    pub(in crate::output) fn at(&self, place: f64) -> [u8; 3] {
        if !place.is_finite() {
            return UNKNOWN;
        }
        let x = place.clamp(0.0, 1.0) * 4.0;
        let i = (x as usize).min(3);
        let (below, above, t) = (self.0[i], self.0[i + 1], x - i as f64);
        std::array::from_fn(|k| (f64::from(below[k]) * (1.0 - t) + f64::from(above[k]) * t).round() as u8)
    }

    /// Returns the map as a list of CSS colours.
    pub(in crate::output) fn css(&self) -> String {
        self.0.map(|[r, g, b]| format!("#{r:02x}{g:02x}{b:02x}")).join(", ")
    }
}

/// Returns a PNG file of pixels: red, green, blue, opacity.
pub(in crate::output) fn png([width, height]: [usize; 2], pixels: impl Iterator<Item = [u8; 4]>) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("a size above zero and a growing buffer are all it needs");
    let bytes: Vec<u8> = pixels.flatten().collect();
    writer.write_image_data(&bytes).expect("there are width × height pixels");
    writer.finish().expect("the buffer grows");
    file
}
