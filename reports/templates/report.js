// A link into a fold opens it, and the row of a run its jumps; what is printed has all sections open.
const closed = () => [...document.querySelectorAll("section > details:not([open])")];
const reveal = (name) => {
  const target = document.getElementById(name);
  const folds = target ? [target.closest("section > details"), target.querySelector("details")].filter(Boolean) : [];
  folds.forEach((fold) => { fold.open = true; });
  if (folds.length) target.scrollIntoView();
};
addEventListener("load", () => reveal(location.hash.slice(1)));
document.addEventListener("click", (event) => {
  const link = event.target.closest("a[href^='#']");
  if (link) reveal(link.getAttribute("href").slice(1));
});
let opened = [];
addEventListener("beforeprint", () => { opened = closed(); opened.forEach((fold) => { fold.open = true; }); });
addEventListener("afterprint", () => opened.forEach((fold) => { fold.open = false; }));

// Over the drawn jumps of a run, the one below the pointer is told.
document.querySelectorAll(".jumps").forEach((fold) => {
  const drawn = fold.querySelector("svg");
  const told = fold.querySelector("span");
  const range = told.textContent;
  drawn.addEventListener("pointermove", (event) => {
    const jumps = fold.querySelector("p").textContent.split(", ");
    const box = drawn.getBoundingClientRect();
    const share = ((event.clientX - box.x) * 126 / box.width - 3) / 120;
    told.textContent = `jump ${jumps[Math.round(Math.min(Math.max(share, 0), 1) * (jumps.length - 1))]} mm`;
  });
  drawn.addEventListener("pointerleave", () => { told.textContent = range; });
});

// A figure fills the window on request; there the wheel and two buttons zoom, and dragging moves it.
const button = (text, act) => {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.addEventListener("click", act);
  return made;
};
const enlarge = (drawing) => {
  const dialog = document.createElement("dialog");
  const copy = drawing.cloneNode(true);
  copy.removeAttribute("style");
  const box = copy.viewBox.baseVal;
  const zoom = (by, x, y) => {
    box.x = x - (x - box.x) * by;
    box.y = y - (y - box.y) * by;
    box.width *= by;
    box.height *= by;
  };
  const inMiddle = (by) => () => zoom(by, box.x + box.width / 2, box.y + box.height / 2);
  dialog.append(button("+", inMiddle(0.7)), button("\u2212", inMiddle(1 / 0.7)), button("close", () => dialog.close()), copy);
  copy.addEventListener("wheel", (event) => {
    event.preventDefault();
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(copy.getScreenCTM().inverse());
    zoom(event.deltaY > 0 ? 1.25 : 0.8, at.x, at.y);
  }, { passive: false });
  copy.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    box.x -= event.movementX / copy.getScreenCTM().a;
    box.y -= event.movementY / copy.getScreenCTM().d;
  });
  copy.addEventListener("click", (event) => { if (event.target.closest("a")) dialog.close(); });
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
};
document.querySelectorAll("figure").forEach((figure) => {
  const drawing = figure.querySelector("svg");
  figure.querySelector("figcaption").append(" ", button("enlarge", () => enlarge(drawing)));
});
