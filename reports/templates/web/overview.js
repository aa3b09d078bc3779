// The table of runs: sorted by a click on a head, narrowed by chips or by --where's language, drawn a page at a time.
import { askJson, byId, onChange } from "/static/common.js";

const AT_ONCE = 300;
const COLLATOR = new Intl.Collator(undefined, { numeric: true });  // made once: of 10 000 runs a sort asks it 100 000 times
let attention = null;
const lookAt = (run) => [...new Set((attention?.[run.name] ?? []).map(({ code }) => code.replaceAll("_", " ")))];
const text = (value) => (value === null || value === undefined ? "" : String(value));
const jumpsText = (run) => (run.found === null ? text(run.made || "") : `${run.found}/${run.made}`);
const COLUMNS = [
  { title: "run", of: (run) => run.name },
  { title: "day", of: (run) => `${run.day} ${String(run.position_in_day).padStart(4)}`, shown: (run) => run.day },
  { title: "condition", of: (run) => run.condition || run.kind },
  { title: "J a jump", of: (run) => run.joules_per_jump, shown: (run) => text(run.joules_per_jump?.toFixed(1)), number: true },
  { title: "apex, mm", of: (run) => run.apex_height_m, shown: (run) => (run.apex_height_m === null ? "" : (run.apex_height_m * 1000).toFixed(1)), number: true },
  { title: "jumps", of: (run) => run.found, shown: jumpsText, number: true },
  { title: "count", of: (run) => run.counted, number: true },
  { title: "reviewed", of: (run) => run.reviewed, number: true },
  { title: "look at", of: (run) => (run.state === "void" ? "void" : lookAt(run).join(", ")), className: "flags" },
];
let book = null;
let sorted = { column: 1, down: false };
let chosen = {};
let shown = AT_ONCE;

const kept = () => {
  const runs = book.runs.filter((run) => Object.entries(chosen).every(([factor, levels]) => levels.size === 0 || levels.has(run.levels[factor])));
  const { of } = COLUMNS[sorted.column];
  const empty = (value) => value === null || value === undefined || value === "";
  return runs.sort((one, other) => {
    const [a, b] = [of(one), of(other)];
    if (empty(a) || empty(b)) return empty(a) - empty(b);
    const order = typeof a === "number" ? a - b : COLLATOR.compare(a, b);
    return sorted.down ? -order : order;
  });
};

const cell = (column, run) => {
  const made = document.createElement("td");
  if (column.number) made.className = "number";
  if (column.className) made.className = column.className;
  if (column === COLUMNS[0]) {
    const link = document.createElement("a");
    link.href = `/runs/${encodeURIComponent(run.name)}`;
    link.textContent = run.name;
    made.append(link);
  } else {
    made.textContent = (column.shown ?? ((one) => text(column.of(one))))(run);
  }
  return made;
};

const counted = (count, what) => `${count} ${what}${count === 1 ? "" : "s"}`;
const draw = () => {
  const runs = kept();
  const rows = runs.slice(0, shown).map((run) => {
    const row = document.createElement("tr");
    if (run.state === "void") row.className = "void";
    row.append(...COLUMNS.map((column) => cell(column, run)));
    return row;
  });
  document.querySelector("#runs tbody").replaceChildren(...rows);
  byId("more").hidden = runs.length <= shown;
  const reviewed = runs.reduce((sum, run) => sum + (run.reviewed ?? 0), 0);
  const toReview = runs.reduce((sum, run) => sum + (run.to_review ?? 0), 0);
  const plan = book.planned ? `, ${book.planned_made} of ${book.planned} planned` : "";
  byId("progress").textContent = `${counted(runs.length, "run")}${plan}; ${reviewed} of ${toReview} jumps reviewed`
    + (attention === null ? "." : `; ${counted(runs.filter((run) => lookAt(run).length).length, "run")} to look at.`);
  byId("last").hidden = book.last_in === null;
  if (book.last_in) byId("last").textContent = `Last in: ${book.last_in.name}, ${book.last_in.at}`;
  document.querySelectorAll("#runs thead th").forEach((head, place) => {
    head.ariaSort = place === sorted.column ? (sorted.down ? "descending" : "ascending") : "none";
  });
};

const heads = () => {
  const made = COLUMNS.map((column, place) => {
    const head = document.createElement("th");
    head.scope = "col";
    if (column.number) head.className = "number";
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = column.title;
    button.addEventListener("click", () => {
      sorted = { column: place, down: sorted.column === place && !sorted.down };
      draw();
    });
    head.append(button);
    return head;
  });
  document.querySelector("#runs thead tr").replaceChildren(...made);
};

const chips = () => {
  const made = book.factors.map((factor) => {
    const group = document.createElement("span");
    group.append(factor.title);
    factor.levels.forEach((level) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = level;
      button.ariaPressed = Boolean(chosen[factor.name]?.has(level));
      button.addEventListener("click", () => {
        const levels = chosen[factor.name] ??= new Set();
        if (!levels.delete(level)) levels.add(level);
        button.ariaPressed = levels.has(level);
        draw();
      });
      group.append(button);
    });
    return group;
  });
  byId("chips").replaceChildren(...made);
};

let asked = 0;
const load = async () => {
  const turn = asked += 1;  // an answer that another one has overtaken is dropped
  const where = byId("where").value.trim();
  const query = where ? `?where=${encodeURIComponent(where)}` : "";
  try {
    const found = await askJson(`/api/runs${query}`);
    if (turn !== asked) return;
    book = found;
    byId("refused").textContent = "";
  } catch (error) {
    if (turn !== asked) return;
    if (![404, 422].includes(error.status)) throw error;
    byId("refused").textContent = error.message;
    return;
  }
  chips();
  draw();
  const found = await askJson(`/api/attention${query}`);
  if (turn !== asked) return;
  attention = found;
  draw();
};

heads();
const look = onChange(load);
byId("filter").addEventListener("submit", (event) => { event.preventDefault(); look(); });
byId("more").addEventListener("click", () => { shown += AT_ONCE; draw(); });
await look();
