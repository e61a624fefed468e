// Colour maps that colour-blind eyes can read, and the scale from values to colours.

/** Viridis (Smith and van der Walt 2015): lightness grows evenly. */
const VIRIDIS = ["#440154", "#482878", "#3e4989", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"];
/** From pale gelatin to dark blue, after cividis (Nuñez et al. 2018): the same for most colour-blind eyes. */
const GELATIN = ["#faf0cf", "#efd998", "#dcc06f", "#bfa66c", "#9d8f72", "#7d7c76", "#5f6876", "#3f5478", "#1d3b70", "#00224e"];
/** Blue, pale and orange-brown, for values of both signs. */
const SIGNED = ["#2166ac", "#4393c3", "#92c5de", "#d1e5f0", "#f7f7f7", "#fee0b6", "#fdb863", "#e08214", "#b35806"];

/** Returns the colours of the map for a scale; gel at rest is pale, like gelatin. */
export function mapOf(scale) {
  const maps = { signed: SIGNED, linear: VIRIDIS, logarithmic: GELATIN, "from-zero": GELATIN };
  return maps[scale];
}

function channels(colour) {
  return [1, 3, 5].map((start) => parseInt(colour.slice(start, start + 2), 16));
}

/** Returns a linear channel, 0 to 1, of a channel of sRGB, 0 to 255. */
function linear(channel) {
  const c = channel / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
}

/** Returns 256 colours of a map: red, green, blue, linear. */
export function table(map) {
  const stops = map.map(channels);
  const result = new Float32Array(3 * 256);
  for (let i = 0; i < 256; i += 1) {
    const place = (i / 255) * (stops.length - 1);
    const first = Math.min(Math.floor(place), stops.length - 2);
    for (let k = 0; k < 3; k += 1) {
      const below = stops[first][k];
      result[3 * i + k] = linear(below + (place - first) * (stops[first + 1][k] - below));
    }
  }
  return result;
}

/** Returns the range of a field over frames, that of all of its parts, on the scale on which it is shown. */
export function rangeOf(frames, { index, stored, scale }) {
  const ranges = frames.flatMap((frame) => frame.parts.map((part) => part.ranges[index]).filter(Boolean));
  const highest = ranges.reduce((a, b) => (b[1] > a[1] ? b : a));
  if (stored === "logarithmic") {
    return scale === "logarithmic" ? highest : [0, highest[1]];
  }
  return [Math.min(...ranges.map((range) => range[0])), highest[1]];
}

/** Returns the value of a quantised value. */
function dequantise(step, [low, high], scale) {
  return scale === "logarithmic" ? low * (high / low) ** (step / 255) : low + (step / 255) * (high - low);
}

/** Returns the place of a value in a range, 0 to 1. */
function placeOf(value, [low, high], scale) {
  const place = scale === "logarithmic" ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.min(1, Math.max(0, place));
}

/** Returns the value at a place of a range, 0 to 1. */
export function valueAt(place, range, scale) {
  return dequantise(255 * place, range, scale);
}

/** Returns for each quantised value of a part its number in the colour table. */
export function colourNumbers(partRange, range, { stored, scale }) {
  return Uint8Array.from({ length: 256 }, (_, step) => Math.round(255 * placeOf(dequantise(step, partRange, stored), range, scale)));
}
