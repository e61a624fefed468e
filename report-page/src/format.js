// Numbers with units, as the rest of the report writes them.

const PREFIXES = ["p", "n", "µ", "m", "", "k", "M", "G", "T"];

function digits(value, significant) {
  const size = Math.abs(value);
  const places = size === 0 ? 0 : Math.min(6, Math.max(0, significant - 1 - Math.floor(Math.log10(size))));
  return value.toFixed(places).replace("-", "−");
}

/** Returns a value with the prefix of its unit that suits `scale`, in so many significant digits. */
export function quantity(value, unit, scale = value, significant = 3) {
  if (unit === "") {
    return digits(value, significant);
  }
  if (unit.startsWith("1/")) {
    return `${Number(value.toPrecision(significant)).toExponential()} ${unit}`;
  }
  const size = Math.abs(scale);
  const step = size > 0 ? Math.floor(Math.log10(size * (1 + 1e-9)) / 3) : 0;
  const thousands = Math.min(4, Math.max(-4, step));
  return `${digits(value / 1000 ** thousands, significant)} ${PREFIXES[thousands + 4]}${unit}`;
}
