// Plots that can be read off and zoomed, in the place of the drawn ones.

import uPlot from "uplot";
import { inflate } from "./data.js";

const HEIGHT = 260;

function style(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Returns ascending abscissae in which equal ones lie a little apart: uPlot keeps one value at each. */
function apart(x, range) {
  const step = 1e-9 * Math.max(Math.abs(range[0]), Math.abs(range[1]), Number.MIN_VALUE);
  const all = [];
  for (const value of x) {
    const least = all.length > 0 ? all[all.length - 1] + step : value;
    all.push(value === null || value > least ? value : least);
  }
  return all;
}

/** Returns the columns that uPlot reads: the abscissae of all curves and both ends of the axis, and each curve at them. */
function columns({ curves, horizontal }) {
  const ends = [horizontal.range, [null, null]];
  return uPlot.join([...curves.map(({ x, y }) => [apart(x, horizontal.range), y]), ends]).slice(0, -1);
}

function number(value) {
  return value === null || value === undefined ? "–" : String(Number(value.toPrecision(3)));
}

function axes({ horizontal, vertical }) {
  const ink = { stroke: () => style("--ink"), grid: { stroke: () => style("--line"), width: 1 }, ticks: { stroke: () => style("--line"), width: 1 } };
  const power = (_, splits) => splits.map((value) => (Number.isInteger(value) ? `1e${value}` : ""));
  return [
    { ...ink, label: `${horizontal.name}, ${horizontal.unit}`, labelSize: 22, size: 40 },
    { ...ink, label: vertical.title, labelSize: 22, size: 62, ...(vertical.decades ? { values: power } : {}) },
  ];
}

function options(plot, width) {
  const { horizontal, vertical } = plot;
  const fromZero = (_, low, high) => [1.05 * Math.min(0, low ?? 0), 1.05 * Math.max(0, high ?? 1)];
  const value = (_, raw) => (vertical.decades && raw !== null ? Number((10 ** raw).toPrecision(3)).toExponential() : number(raw));
  const series = plot.curves.map(({ name, colour, dash, dots }) => ({
    label: name,
    stroke: colour,
    width: dots ? 0 : 2,
    dash,
    spanGaps: true,
    points: dots ? { show: true, size: 7, fill: colour } : { show: false },
    value,
  }));
  return {
    width,
    height: HEIGHT,
    scales: { x: { time: false, range: (_, low, high) => [low, high] }, ...(vertical.fromZero ? { y: { range: fromZero } } : {}) },
    axes: axes(plot),
    series: [{ label: `${horizontal.name}, ${horizontal.unit}`, value: (_, raw) => number(raw) }, ...series],
    cursor: { sync: { key: `${horizontal.name}, ${horizontal.unit}`, setSeries: false }, drag: { x: true, y: false } },
    legend: { live: true },
  };
}

/** Replaces one drawn plot. */
async function showPlot(figure) {
  const script = figure.querySelector("script.curves");
  const plot = JSON.parse(new TextDecoder().decode(await inflate(script.textContent)));
  const place = document.createElement("div");
  place.className = "live";
  figure.querySelector(".still").before(place);
  const drawn = new uPlot(options(plot, place.clientWidth || 640), columns(plot), place);
  figure.classList.add("is-live");
  // The legend has the signs of the key, with their dash patterns; its first row is the abscissa.
  const signs = figure.querySelectorAll(".key .sign");
  [...place.querySelectorAll(".u-series")].slice(1).forEach((row, i) => row.querySelector(".u-marker").replaceWith(signs[i].cloneNode(true)));
  new ResizeObserver(() => {
    if (place.clientWidth > 0) {
      drawn.setSize({ width: place.clientWidth, height: HEIGHT });
    }
  }).observe(place);
  return drawn;
}

/** Replaces all drawn plots. */
export async function showPlots() {
  const figures = [...document.querySelectorAll("figure.plot")].filter((figure) => figure.querySelector("script.curves"));
  const drawn = await Promise.all(figures.map(showPlot));
  const scheme = window.matchMedia("(prefers-color-scheme: dark)");
  scheme.addEventListener("change", () => drawn.forEach((plot) => plot.redraw()));
}
