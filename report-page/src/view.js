// View of the shot: frames, their colours, and what the controls do.

import { colourNumbers, mapOf, rangeOf, table } from "./colours.js";
import { choicesOf, drawBar, listChoices, makeControls } from "./controls.js";
import { decodeFrame } from "./data.js";
import { quantity } from "./format.js";
import { addViewButtons } from "./save.js";
import { shapes } from "./shapes.js";
import { Stage } from "./stage.js";

const FRAMES_PER_SECOND = 8;

/** Returns the box around the parts of these kinds, m. */
function boxOf(frames, kinds) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const part of frames.flatMap((frame) => frame.parts).filter(({ kind }) => kinds.includes(kind))) {
    part.positions.forEach((x, i) => {
      low[i % 3] = Math.min(low[i % 3], x);
      high[i % 3] = Math.max(high[i % 3], x);
    });
  }
  return { low, high };
}

/** Returns the box of the whole gel: mirrored, revolved or with the thickness of a slab. */
function wholeBox({ low, high }, { dimension, mirrored }, thickness) {
  const box = { low: [...low], high: [...high] };
  const mirror = (axis) => {
    const reach = Math.max(Math.abs(low[axis]), Math.abs(high[axis]));
    [box.low[axis], box.high[axis]] = [-reach, reach];
  };
  mirrored.forEach(mirror);
  if (dimension === "axisymmetric") {
    mirror(0);
    [box.low[1], box.high[1]] = [box.low[0], box.high[0]];
  } else if (dimension === "planar") {
    [box.low[1], box.high[1]] = [-thickness / 2, thickness / 2];
  }
  return box;
}

/** Returns the number of the frame nearest to a time, s. */
function nearest(frames, time) {
  const distances = frames.map((frame) => Math.abs(frame.time - time));
  return distances.indexOf(Math.min(...distances));
}

/** View of a run. */
class View {
  constructor(place, data, frames) {
    this.data = data;
    this.frames = frames;
    const gel = boxOf(frames, ["surface", "section"]);
    const size = gel.high.map((high, axis) => high - gel.low[axis]);
    this.thickness = 0.15 * Math.max(size[0], size[2]);
    this.box = wholeBox(gel, data, this.thickness);
    this.controls = makeControls(place);
    this.choices = choicesOf(data.fields);
    listChoices(this.controls, this.choices);
    const width = this.box.high[0] - this.box.low[0];
    this.stage = new Stage(this.controls.canvas, size[2] > 1.25 * width);
    this.controls.time.max = String(frames.length - 1);
    this.controls.cuts.hidden = data.dimension === "planar";
    this.listen();
    this.fit();
    this.showMoment(nearest(frames, data.moment));
    this.look();
  }

  listen() {
    const { controls } = this;
    const on = (control, event, act) => control.addEventListener(event, act);
    on(controls.time, "input", () => this.showMoment(Number(controls.time.value)));
    [controls.field, controls.scale, controls.lines].forEach((control) => on(control, "input", () => this.draw()));
    [controls.half, controls.cut].forEach((control) => on(control, "input", () => this.draw()));
    on(controls.clear, "input", () => {
      this.stage.setTransparent(controls.clear.checked);
      this.stage.render();
    });
    on(controls.camera, "input", () => this.look());
    on(controls.reset, "click", () => this.reset());
    on(controls.play, "click", () => this.setPlaying(!this.timer));
    on(controls.canvas, "keydown", (event) => this.press(event));
    new ResizeObserver(() => this.fit()).observe(controls.picture);
  }

  press(event) {
    const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (step !== undefined && event.shiftKey) {
      const isAcross = event.key === "ArrowLeft" || event.key === "ArrowRight";
      this.stage.turn(isAcross ? 0.1 * step : 0, isAcross ? 0 : -0.1 * step);
    } else if (step !== undefined) {
      this.showMoment(Math.min(this.frames.length - 1, Math.max(0, this.moment + step)));
    } else if (event.key === " ") {
      this.setPlaying(!this.timer);
    } else {
      return;
    }
    event.preventDefault();
  }

  /** Starts or stops the film; at its end it starts again. */
  setPlaying(isPlaying) {
    cancelAnimationFrame(this.timer);
    this.timer = 0;
    this.controls.play.textContent = isPlaying ? "Pause" : "Play";
    if (!isPlaying) {
      return;
    }
    let last = performance.now();
    const tick = (now) => {
      if (now - last >= 1000 / (FRAMES_PER_SECOND * Number(this.controls.speed.value))) {
        last = now;
        this.showMoment((this.moment + 1) % this.frames.length);
      }
      this.timer = requestAnimationFrame(tick);
    };
    this.timer = requestAnimationFrame(tick);
  }

  showMoment(moment) {
    this.moment = moment;
    const when = quantity(this.frames[moment].time, "s", undefined, 3);
    this.controls.time.value = String(moment);
    this.controls.time.setAttribute("aria-valuetext", when);
    this.controls.clock.textContent = when;
    this.draw();
  }

  /** Draws the frame that is shown, with the choices of the controls. */
  draw() {
    const { controls, data, stage } = this;
    const frame = this.frames[this.moment];
    const choice = this.choices[Number(controls.field.value)];
    const isGel = choice.index === undefined;
    const plain = shapes(frame, data, this.thickness);
    [controls.clear, controls.scale].forEach((control) => Object.assign(control, { disabled: isGel }));
    controls.legend.hidden = isGel;
    const isPlanar = data.dimension === "planar";
    const cut = this.cutHeight(frame);
    stage.cut(isPlanar ? null : cut, 1e-3 * this.thickness);
    const all = isGel ? plain : this.colouredShapes(plain, frame, choice);
    stage.show(all, isPlanar || cut !== null, controls.lines.checked, 5e-4 * this.thickness);
    stage.render();
  }

  /** Returns shapes with the colours of a field, and draws its bar. */
  colouredShapes(plain, frame, choice) {
    const range = rangeOf(this.controls.scale.value === "run" ? this.frames : [frame], choice);
    const colours = table(mapOf(choice.scale));
    drawBar(this.controls, choice, range);
    return plain.map((shape) => this.coloured(shape, choice, range, colours));
  }

  /** Returns a shape with the colours of a field. */
  coloured(shape, choice, range, colours) {
    if (shape.role === "body") {
      return shape;
    }
    const numbers = colourNumbers(shape.part.ranges[choice.index], range, choice);
    const values = shape.part.values[choice.index];
    const result = new Float32Array(3 * shape.sources.length);
    shape.sources.forEach((source, i) => {
      const first = 3 * numbers[values[source]];
      result.set(colours.subarray(first, first + 3), 3 * i);
    });
    return { ...shape, colours: result };
  }

  /** Returns the height y of the cut, m; null for a whole gel. */
  cutHeight(frame) {
    const { controls } = this;
    controls.cut.disabled = !controls.half.checked;
    if (!controls.half.checked) {
      controls.cutPlace.textContent = "";
      return null;
    }
    const place = Number(controls.cut.value) / 100;
    const reach = place < 0 ? frame.plane - this.box.low[1] : this.box.high[1] - frame.plane;
    const offset = place * reach;
    controls.cutPlace.textContent = place === 0 ? "through the shot" : `${quantity(offset, "m", reach)} from the shot`;
    return frame.plane + offset;
  }

  look() {
    const name = this.controls.camera.value;
    if (name === "shot") {
      this.stage.look("overview", ...this.shotBox());
      return;
    }
    if (name !== "projectile") {
      this.stage.look(name, this.visibleLow(), this.box.high);
      return;
    }
    const bodies = boxOf([this.frames[this.moment]], ["body"]);
    const size = Math.max(...bodies.high.map((high, axis) => high - bodies.low[axis]));
    const grown = [bodies.low.map((x) => x - 1.5 * size), bodies.high.map((x) => x + 1.5 * size)];
    this.stage.look("overview", ...(Number.isFinite(size) ? grown : [this.box.low, this.box.high]));
  }

  /** Returns the lower corner of the box of the visible gel: of a gel that is cut open, the part behind the cut. */
  visibleLow() {
    const [x, y, z] = this.box.low;
    const isCut = this.controls.half.checked && this.data.dimension !== "planar";
    return [x, isCut ? this.frames[this.moment].plane : y, z];
  }

  /** Returns the corners of the box around the way of the bodies in the gel, grown by a tenth of its length. */
  shotBox() {
    const { low, high } = boxOf(this.frames, ["body"]);
    const inside = (corner) => corner.map((x, axis) => Math.min(this.box.high[axis], Math.max(this.box.low[axis], x)));
    const [lower, upper] = [inside(low), inside(high)];
    const margin = 0.1 * Math.max(...upper.map((x, axis) => x - lower[axis]));
    return [lower.map((x) => x - margin), upper.map((x) => x + margin)];
  }

  reset() {
    this.controls.camera.value = "overview";
    this.controls.cut.value = "0";
    this.controls.half.checked = true;
    this.draw();
    this.look();
  }

  fit() {
    const { clientWidth, clientHeight } = this.controls.picture;
    if (clientWidth > 0 && clientHeight > 0) {
      this.stage.resize(clientWidth, clientHeight);
    }
  }
}

const NOTES = {
  planar: "The plane gel is drawn as a slab. ",
  axisymmetric: "The gel is computed in a half plane and drawn as the body of revolution. ",
  spatial: "",
};

function hasWebGl() {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

/** Shows the view in its place, and hides the pictures that stand for it; without WebGL nothing changes. */
export async function showView(place, text) {
  if (!hasWebGl()) {
    return;
  }
  const data = JSON.parse(text);
  const frames = [];
  for (const frame of data.frames) {
    frames.push(await decodeFrame(frame));
  }
  place.hidden = false;
  try {
    const view = new View(place, data, frames);
    const mirror = data.mirrored.length > 0 ? `One ${data.mirrored.length > 1 ? "quarter" : "half"} is computed and mirrored. ` : "";
    view.controls.note.textContent = `${NOTES[data.dimension]}${mirror}Drag to turn, wheel or pinch to zoom, right button to move. Fields of elements are shown as means at the nodes.`;
    addViewButtons(place, view);
    document.body.classList.add("has-view");
  } catch (error) {
    place.hidden = true;
    place.replaceChildren();
    console.warn(`The pictures stand for the view: ${error.message}`);
  }
}
