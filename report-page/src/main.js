// Start of the page's script.

import { openInPrint } from "./print.js";
import { showPlots } from "./plots.js";
import { addSaveButtons } from "./save.js";
import { showView } from "./view.js";

const place = document.getElementById("view");
const data = document.getElementById("view-data");
openInPrint();
addSaveButtons();
const work = [showPlots()];
if (place !== null && data !== null) {
  work.push(showView(place, data.textContent));
}
Promise.allSettled(work).then((results) => {
  results.filter(({ reason }) => reason).forEach(({ reason }) => console.warn(`A part of the page stays still: ${reason.message}`));
  document.body.classList.add("is-ready");
});
