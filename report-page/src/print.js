// Folded parts are opened for the printer, and folded again after it.

export function openInPrint() {
  let opened = [];
  window.addEventListener("beforeprint", () => {
    opened = [...document.querySelectorAll("main details:not(.licences):not([open])")];
    opened.forEach((part) => {
      part.open = true;
    });
  });
  window.addEventListener("afterprint", () => {
    opened.forEach((part) => {
      part.open = false;
    });
  });
}
