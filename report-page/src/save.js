// Buttons that save a picture, a drawing or a film, and copy a table; nothing leaves the page but into the reader's files.

const SVG = "http://www.w3.org/2000/svg";
/** Properties of a drawing that the style sheet of the page sets. */
const STYLED = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "font", "text-anchor", "opacity"];
/** Pixels of a saved picture per pixel of the page. */
const SHARPNESS = 2;
const FILM_BITS_PER_SECOND = 8e6;
const FILM_FRAMES_PER_SECOND = 8;

/** Returns a button in the row of buttons of a place, which it makes if there is none. */
function addButton(place, text, act) {
  let row = place.querySelector(":scope > .save");
  if (!row) {
    row = document.createElement("p");
    row.className = "save";
    place.append(row);
  }
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = text;
  button.addEventListener("click", () => act(button));
  row.append(button);
  return button;
}

/** Returns a name for a file: the name of the page and of the thing, in small letters and hyphens. */
function fileName(what, ending) {
  const plain = (text) => text.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "").slice(0, 60);
  return `${plain(document.querySelector("header code")?.textContent ?? "runs")}-${plain(what)}.${ending}`;
}

function saveBlob(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** Sets the attributes of an element. */
function withAttributes(element, attributes) {
  Object.entries(attributes).forEach(([name, value]) => element.setAttribute(name, value));
  return element;
}

function made(name, attributes, text = "") {
  const element = withAttributes(document.createElementNS(SVG, name), attributes);
  element.textContent = text;
  return element;
}

/** Returns a copy of an element of a drawing that needs no style sheet. */
function styledCopy(element) {
  const copy = element.cloneNode(true);
  const [from, to] = [element, copy].map((root) => [root, ...root.querySelectorAll("*")]);
  from.forEach((one, i) => {
    const style = getComputedStyle(one);
    STYLED.forEach((property) => to[i].style.setProperty(property, style.getPropertyValue(property)));
  });
  return copy;
}

/** Returns the drawing of a figure as text, with its title above and its legend below, on the ground of the page. */
function svgText(figure) {
  const svg = figure.querySelector("svg:not(.sign)");
  const { width, height } = svg.viewBox.baseVal;
  // Plots have eight units to a pixel.
  const unit = width > 2000 ? 8 : 1;
  const entries = [...figure.querySelectorAll(".key li")];
  const style = getComputedStyle(document.body);
  const ink = { fill: style.color, "font-family": "sans-serif", "font-size": 14 * unit };
  const [above, line] = [26 * unit, 20 * unit];
  const whole = made("svg", { xmlns: SVG, viewBox: `0 0 ${width} ${above + height + line * entries.length + 6 * unit}` });
  const drawing = withAttributes(styledCopy(svg), { x: 0, y: above, width, height });
  drawing.removeAttribute("style");
  const title = figure.querySelector("figcaption").textContent;
  whole.append(
    made("rect", { width: "100%", height: "100%", fill: style.backgroundColor }),
    made("text", { ...ink, x: 8 * unit, y: 18 * unit, "font-weight": 600 }, title),
    drawing,
    ...entries.flatMap((entry, i) => {
      const y = above + height + line * i;
      const sign = withAttributes(styledCopy(entry.querySelector(".sign")), { x: 8 * unit, y: y + 3 * unit, width: 28 * unit, height: 12 * unit });
      return [sign, made("text", { ...ink, x: 44 * unit, y: y + 14 * unit }, entry.textContent)];
    }),
  );
  const box = whole.viewBox.baseVal;
  return new XMLSerializer().serializeToString(withAttributes(whole, { width: box.width / unit, height: box.height / unit }));
}

/** Returns the drawing of a figure as a PNG file. */
async function pngOf(figure) {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svgText(figure))}`;
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [image.width, image.height].map((size) => Math.round(SHARPNESS * size));
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}

function addFigureButtons(figure) {
  const title = figure.querySelector("figcaption").textContent.split(",")[0];
  addButton(figure, "Save PNG", async () => saveBlob(await pngOf(figure), fileName(title, "png")));
  addButton(figure, "Save SVG", () => saveBlob(new Blob([svgText(figure)], { type: "image/svg+xml" }), fileName(title, "svg")));
}

/** Returns a table as lines of cells between tabs, as spreadsheets read them. */
function tableText(table) {
  const shown = [...table.rows].map((row) => [...row.cells].filter((cell) => getComputedStyle(cell).display !== "none"));
  return shown.map((cells) => cells.map((cell) => cell.textContent.trim().replace(/\s+/g, " ")).join("\t")).join("\n");
}

async function copyText(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    // Pages of a file may have no clipboard of their own.
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
}

/** Adds the buttons of all drawings and tables. */
export function addSaveButtons() {
  const figures = [...document.querySelectorAll("figure")].filter((figure) => figure.querySelector("svg:not(.sign)"));
  figures.forEach(addFigureButtons);
  document.querySelectorAll("div.wide").forEach((place) => {
    const button = addButton(place, "Copy table", async () => {
      await copyText(tableText(place.querySelector("table")));
      button.textContent = "Copied";
      setTimeout(() => {
        button.textContent = "Copy table";
      }, 1500);
    });
  });
}

/** Returns the format of a film that this browser can write; nothing if it can write none. */
function filmType() {
  const all = ["video/mp4;codecs=avc1", "video/webm;codecs=vp9", "video/webm"];
  return window.MediaRecorder ? all.find((type) => MediaRecorder.isTypeSupported(type)) : undefined;
}

/** Returns a canvas with the picture of the view on the ground of the page, with the time in its corner. */
function composed(view, copy) {
  const { canvas } = view.controls;
  if (copy.width !== canvas.width || copy.height !== canvas.height) {
    [copy.width, copy.height] = [canvas.width, canvas.height];
  }
  const context = copy.getContext("2d");
  const style = getComputedStyle(document.documentElement);
  context.fillStyle = style.getPropertyValue("--panel");
  context.fillRect(0, 0, copy.width, copy.height);
  context.drawImage(canvas, 0, 0);
  const size = Math.round(copy.height / 22);
  context.font = `600 ${size}px system-ui, sans-serif`;
  context.fillStyle = style.getPropertyValue("--ink");
  context.fillText(view.controls.clock.textContent, size, 1.5 * size);
  return copy;
}

/** Records the whole run, one frame after the other. */
async function saveFilm(view, type, button) {
  const copy = composed(view, document.createElement("canvas"));
  const stream = copy.captureStream();
  const recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: FILM_BITS_PER_SECOND });
  const chunks = [];
  recorder.addEventListener("dataavailable", ({ data }) => chunks.push(data));
  const stopped = new Promise((done) => recorder.addEventListener("stop", done, { once: true }));
  const before = view.moment;
  button.disabled = true;
  view.setPlaying(false);
  recorder.start();
  for (let moment = 0; moment < view.frames.length; moment += 1) {
    view.showMoment(moment);
    composed(view, copy);
    button.textContent = `Recording ${moment + 1} of ${view.frames.length}`;
    await new Promise((done) => setTimeout(done, 1000 / (FILM_FRAMES_PER_SECOND * Number(view.controls.speed.value))));
  }
  recorder.stop();
  await stopped;
  stream.getTracks().forEach((track) => track.stop());
  button.disabled = false;
  button.textContent = "Save film";
  view.showMoment(before);
  saveBlob(new Blob(chunks, { type }), fileName("film", type.startsWith("video/mp4") ? "mp4" : "webm"));
}

/** Adds the buttons of the view; a film only where the browser can write one. */
export function addViewButtons(place, view) {
  addButton(place, "Save picture", () => {
    const name = fileName(`view ${view.controls.clock.textContent}`, "png");
    composed(view, document.createElement("canvas")).toBlob((blob) => saveBlob(blob, name), "image/png");
  });
  const type = filmType();
  if (type && view.frames.length > 1) {
    const button = addButton(place, "Save film", () => saveFilm(view, type, button));
  }
}
