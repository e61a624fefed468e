// Controls below the view: native buttons, sliders and lists with labels.

import { quantity } from "./format.js";
import { mapOf, valueAt } from "./colours.js";

const TEMPLATE = `
<div class="view-picture"><canvas id="view-canvas" tabindex="0" role="img"
 aria-label="The shot in three dimensions. Arrow keys move through time, with Shift they turn the gel, the space bar plays."></canvas>
<p class="view-clock"><output id="view-clock"></output></p></div>
<div class="view-bar"><span id="view-quantity"></span><div class="bar"></div><div class="ticks"></div></div>
<div class="view-time"><button type="button" id="view-play">Play</button>
<label for="view-time">Time</label><input id="view-time" type="range" min="0" step="1"/>
<label for="view-speed">Speed</label><select id="view-speed"><option value="0.25">¼</option><option value="0.5">½</option>
<option value="1" selected>1</option><option value="2">2</option><option value="4">4</option></select></div>
<div class="view-options"><p><label for="view-field">Colour</label><select id="view-field"></select></p>
<p><label for="view-scale">Scale</label><select id="view-scale"><option value="run">of the whole run</option>
<option value="moment">of this moment</option></select></p>
<p><label for="view-camera">View</label><select id="view-camera"><option value="overview">Overview</option>
<option value="front">Front</option><option value="side">Side</option><option value="above">From the entry</option>
<option value="shot">Along the shot</option><option value="projectile">Projectile</option></select>
<button type="button" id="view-reset">Reset view</button></p>
<p class="view-cuts"><label><input id="view-half" type="checkbox" checked/> Cut open</label>
<label for="view-cut">Cut plane</label><input id="view-cut" type="range" min="-100" max="100" value="0" step="1"/>
<output id="view-cut-place"></output></p>
<p><label><input id="view-clear" type="checkbox"/> Transparent gel</label>
<label><input id="view-lines" type="checkbox"/> Mesh</label></p></div>
<p class="view-note" id="view-note"></p>`;

/** Controls of the view by the end of their name: `controls.time` is the slider of time. */
export function makeControls(place) {
  place.innerHTML = TEMPLATE;
  const names = ["canvas", "clock", "quantity", "play", "time", "speed", "field", "scale", "camera", "reset", "half", "cut", "clear", "lines", "note"];
  const controls = Object.fromEntries(names.map((name) => [name, place.querySelector(`#view-${name}`)]));
  controls.cutPlace = place.querySelector("#view-cut-place");
  controls.cuts = place.querySelector(".view-cuts");
  controls.bar = place.querySelector(".bar");
  controls.legend = place.querySelector(".view-bar");
  controls.ticks = place.querySelector(".ticks");
  controls.picture = place.querySelector(".view-picture");
  return controls;
}

/**
 * Returns the choices of colours: the gel as it looks, then each field on a linear scale, and a field with values over
 * several decades on a logarithmic one, too.
 */
export function choicesOf(fields) {
  const ofField = ({ name, unit, scale }, index) => {
    if (scale !== "logarithmic") {
      return [{ name, unit, index, stored: scale, scale }];
    }
    const choice = { unit, index, stored: scale };
    return [{ ...choice, name, scale: "from-zero" }, { ...choice, name: `${name}, logarithmic scale`, scale }];
  };
  return [{ name: "Gel" }, ...fields.flatMap(ofField)];
}

/** Fills the list of colours. */
export function listChoices(controls, choices) {
  choices.forEach(({ name }, i) => controls.field.append(new Option(name, String(i))));
}

/** Draws the colour bar of a field over a range. */
export function drawBar(controls, { name, unit, scale }, range) {
  controls.quantity.textContent = unit ? `${name}, ${unit}` : name;
  controls.bar.style.background = `linear-gradient(to right, ${mapOf(scale).join(", ")})`;
  const largest = Math.max(...range.map(Math.abs));
  const ticks = [0, 0.25, 0.5, 0.75, 1].map((place) => {
    const value = valueAt(place, range, scale);
    const tick = document.createElement("span");
    tick.textContent = quantity(value, unit, scale === "logarithmic" ? value : largest, 3);
    return tick;
  });
  controls.ticks.replaceChildren(...ticks);
}
