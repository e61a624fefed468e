// Start of the page's script.

import { showPlots } from "./plots.js";
import { showView } from "./view.js";

const place = document.getElementById("view");
const data = document.getElementById("view-data");
const work = [showPlots()];
if (place !== null && data !== null) {
  work.push(showView(place, data.textContent));
}
Promise.all(work).then(() => document.body.classList.add("is-ready"));
