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
// A high tone where all is well, a low one twice where it is not; browsers let a page sound only after a click.
let sound = null;
const beep = (well) => (well ? [[880, 0]] : [[220, 0], [220, 0.35]]).forEach(([pitch_hz, after_s]) => {
  const tone = new OscillatorNode(sound, { frequency: pitch_hz });
  const volume = new GainNode(sound, { gain: 0.2 });
  tone.connect(volume).connect(sound.destination);
  tone.start(sound.currentTime + after_s);
  tone.stop(sound.currentTime + after_s + 0.25);
});
byId("sound").addEventListener("click", (event) => {
  if (sound) { sound.close(); sound = null; } else { sound = new AudioContext(); beep(true); }
  event.target.ariaPressed = sound !== null;
});

// What `attention` says is wrong of the newest runs: it looks at the whole book, and the line does not wait for it.
const wrongOf = async (runs) => {
  if (!runs.length) return [];
  const where = runs.slice(0, 12).map((run) => `run="${run}"`).join(" or ");
  const found = await askJson(`/api/attention?where=${encodeURIComponent(where)}`);
  return Object.values(found).flat().filter(({ gravity }) => gravity === "wrong").map(({ what }) => {
    const made = document.createElement("p");
    made.className = "reject";
    made.textContent = what;
    return made;
  });
};

let last = null;
let asked = 0;
const load = async () => {
  const turn = asked += 1;  // an answer that another one has overtaken is dropped
  const found = await askJson("/api/live");
  if (turn !== asked) return;
  const [newest] = found.files;
  const lines = found.lines.map((line) => {
    const made = document.createElement("p");
    made.className = line.concern ? "reject" : "accept";
    made.textContent = line.text;
    return made;
  });
  if (newest && (newest.wrong || !lines.length)) {
    const made = document.createElement("p");
    made.className = newest.wrong ? "reject" : "";
    made.textContent = `${newest.name}${newest.wrong ? `: ${newest.wrong}` : newest.runs.length ? "" : " has no run yet"}`;
    lines.unshift(made);
  }
  byId("line").replaceChildren(...(lines.length ? lines : ["nothing yet"]));
  const rows = found.files.map((file) => {
    const row = document.createElement("tr");
    const runs = file.runs.slice(0, 6).flatMap((run, place) => (place ? [", ", link(run)] : [link(run)]));
    if (file.runs.length > 6) runs.push(` and ${file.runs.length - 6} more`);
    const look = cell(file.wrong);
    look.className = "flags";
    const name = cell(file.name);
    name.className = "name";
    row.append(name, cell(file.at), cell(file.role), cell(runs), look);
    return row;
  });
  document.querySelector("#files tbody").replaceChildren(...rows);
  const wrong = await wrongOf(newest?.runs ?? []);
  if (turn !== asked) return;
  byId("line").append(...wrong);
  const now = newest && `${newest.name} ${newest.at_utc}`;
  if (sound && last !== null && now !== last) beep(!wrong.length && !lines.some((line) => line.className === "reject"));
  last = now;
};
await onChange(load)();
