// The line on what came in last, and the files before it.
import { askJson, byId, onChange } from "/static/common.js";

const cell = (content) => {
  const made = document.createElement("td");
  made.append(...[content].flat());
  return made;
};
const link = (run) => {
  const made = document.createElement("a");
  made.href = `/runs/${encodeURIComponent(run)}`;
  made.textContent = run;
  return made;
};
const load = async () => {
  const found = await askJson("/api/live");
  const [newest] = found.files;
  const lines = found.lines.map((line) => {
    const made = document.createElement("p");
    made.className = line.concern ? "reject" : "accept";
    made.textContent = line.text;
    return made;
  });
  if (newest && (newest.refused || newest.waits || !lines.length)) {
    const made = document.createElement("p");
    made.className = newest.refused || newest.waits ? "reject" : "";
    made.textContent = newest.waits || `${newest.name}${newest.refused ? " was refused" : newest.runs.length ? "" : " has no run yet"}`;
    lines.unshift(made);
  }
  byId("line").replaceChildren(...(lines.length ? lines : ["nothing yet"]));
  const rows = found.files.map((file) => {
    const row = document.createElement("tr");
    const runs = file.runs.slice(0, 6).flatMap((run, place) => (place ? [", ", link(run)] : [link(run)]));
    if (file.runs.length > 6) runs.push(` and ${file.runs.length - 6} more`);
    const look = cell(file.refused ? "refused" : file.waits);
    look.className = "flags";
    row.append(cell(file.name), cell(file.at), cell(file.role), cell(runs), look);
    return row;
  });
  document.querySelector("#files tbody").replaceChildren(...rows);
};
await onChange(load)();
