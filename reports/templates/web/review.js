// Jumps one at a time, by keyboard. A key draws the next jump at once; its verdict is saved behind it, read back, and only
// then shown as saved. What the server did not take yet waits, in order, also over a reload of the page.
import { ask, askJson, byId, colour, post, samplesOf } from "/static/common.js";
import { Axes, boxOf, drawLine, fitted, placeOf } from "/static/trace.js";

const READ_ONLY = document.body.dataset.readOnly === "yes";
const WAITING = "labbook-waiting";
const AHEAD = 2;
const AGAIN_MS = 1000;
const DOUBTS = {
  gap_touched: "it touches a gap",
};

const logs = new Map();
let runs = [];
let at = { run: 0, jump: 0 };
let open = new URLSearchParams(location.search).has("open");
let given = [];
let waiting = JSON.parse(sessionStorage.getItem(WAITING) ?? "[]");
let sending = false;
let trouble = "";

const logOf = (run) => {
  if (!logs.has(run)) {
    logs.set(run, (async () => {
      const log = await askJson(`/api/runs/${encodeURIComponent(run)}/log`);
      log.trace = await samplesOf(run, log.samples);
      return log;
    })().catch((error) => { logs.delete(run); throw error; }));
  }
  return logs.get(run);
};
const loaded = new Map();
const ahead = () => {
  for (let step = 0; step <= AHEAD; step += 1) {
    const run = runs[at.run + step];
    if (run) logOf(run).then((log) => { loaded.set(run, log); draw(); work(); }).catch((error) => { trouble = error.message; status(); });
  }
  [...loaded.keys()].filter((run) => Math.abs(runs.indexOf(run) - at.run) > 20).forEach((run) => { loaded.delete(run); logs.delete(run); });
};
const here = () => loaded.get(runs[at.run]);
const jumpHere = () => here()?.jumps[at.jump];

const middle = (values) => {
  const sorted = [...values].sort((one, other) => one - other);
  return sorted[sorted.length >> 1];
};
const doubtsOf = (log, jump) => {
  const doubts = jump.flags.map((flag) => DOUBTS[flag] ?? flag.replaceAll("_", " "));
  if (jump.apex_height_m === null) doubts.push(jump.why_no_apex ?? "no apex");
  else {
    const heights = log.jumps.filter((one) => one.apex_height_m !== null).map((one) => one.apex_height_m);
    const center = middle(heights);
    const spread = 1.4826 * middle(heights.map((height) => Math.abs(height - center)));
    const apart = (jump.apex_height_m - center) / (spread || Infinity);
    if (Math.abs(apart) > 3.5) doubts.push(`${Math.abs(jump.apex_height_m - center) * 1000 | 0} mm ${apart > 0 ? "above" : "below"} the run's middle`);
  }
  if (jump.excluded && !jump.decided) doubts.push(`left out: ${jump.excluded}`);
  return doubts;
};

const status = () => {
  const known = [...loaded.values()];
  const jumps = known.flatMap((log) => log.jumps);
  const made = counts.reviewed;
  const rejected = jumps.filter((jump) => jump.decided?.verdict === "reject").length;
  const parts = [`${made} of ${counts.jumps} reviewed`];
  if (rejected) parts.push(`${rejected} rejected here`);
  if (waiting.length) parts.push(`${waiting.length} waiting to be saved`);
  if (trouble) parts.push(trouble);
  byId("saved").textContent = parts.join(", ");
  byId("saved").className = waiting.length && trouble ? "wrong" : "soft";
  const share = counts.jumps ? 100 * made / counts.jumps : 0;
  byId("share").style.width = `${share}%`;
  byId("share").parentElement.ariaValueNow = Math.round(share);
};
const counts = { jumps: 0, reviewed: 0 };

const draw = () => {
  const log = here();
  const jump = jumpHere();
  const run = runs[at.run];
  byId("title").textContent = run ? `${run}${open && log ? `: ${log.title}` : ""}` : "Nothing to review";
  if (!log || !jump) return;
  const { time, height } = log.trace;
  const next = log.jumps[at.jump + 1];
  const begin = jump.touchdown_s ?? jump.lift_off_s ?? jump.at_s - 0.4;
  const until = jump.at_s + (jump.apex_height_m === null ? 0.6 : 2.5 * (jump.at_s - begin));
  const end = next ? Math.min(until, next.touchdown_s ?? next.at_s) : until;
  const room = 0.15 * (end - begin);
  const view = [begin - room, end + room];
  const from = Math.max(0, placeOf(time, view[0]) - 1);
  const to = Math.min(time.length, placeOf(time, view[1]) + 1);
  let low = Infinity;
  let high = -Infinity;
  for (let place = from; place < to; place += 1) { low = Math.min(low, height[place]); high = Math.max(high, height[place]); }
  if (jump.apex_height_m !== null) high = Math.max(high, jump.apex_height_m);
  const spare = (high - low || 0.01) * 0.12;
  const { context, width, height: tall } = fitted(byId("jump"));
  const axes = new Axes(boxOf(width, tall), view, [(low - spare) * 1000, (high + spare) * 1000]);
  axes.draw(context, "time (s)", "body height (mm)");
  context.save();
  axes.clip(context);
  context.fillStyle = colour("gap");
  log.gaps.forEach((gap) => context.fillRect(axes.x(gap.start_s), axes.box.top, Math.max(1, axes.x(gap.end_s) - axes.x(gap.start_s)), axes.box.height));
  if (jump.lift_off_s !== null) {  // the run's other jumps, aligned at lift-off
    context.strokeStyle = colour("faint");
    context.globalAlpha = 0.28;
    context.lineWidth = 1;
    log.jumps.filter((other) => other !== jump && other.lift_off_s !== null && other.apex_height_m !== null).forEach((other) => {
      const shift = jump.lift_off_s - other.lift_off_s;
      const first = placeOf(time, begin - shift);
      const last = placeOf(time, end - shift);
      context.beginPath();
      for (let place = first; place < last; place += 1) context.lineTo(axes.x(time[place] + shift), axes.y(height[place] * 1000));
      context.stroke();
    });
    context.globalAlpha = 1;
  }
  const own = [placeOf(time, begin), placeOf(time, end)];
  context.lineWidth = 1.2;
  context.strokeStyle = colour("faint");
  drawLine(context, axes, log.trace, from, own[0] + 1, null);
  drawLine(context, axes, log.trace, Math.max(own[1] - 1, 0), to, null);
  context.strokeStyle = colour("trace");
  context.lineWidth = 1.8;
  drawLine(context, axes, log.trace, own[0], own[1], null);
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "center";
  context.setLineDash([2, 4]);
  context.lineWidth = 1;
  context.strokeStyle = context.fillStyle = colour("soft");
  [[jump.touchdown_s, "touchdown ", "right"], [jump.lift_off_s, " lift-off", "left"]].forEach(([moment, name, side]) => {
    if (moment === null) return;
    context.textAlign = side;
    context.beginPath();
    context.moveTo(axes.x(moment), axes.box.top + 18);
    context.lineTo(axes.x(moment), axes.box.top + axes.box.height);
    context.stroke();
    context.fillText(name, axes.x(moment), axes.box.top + 14);
  });
  context.setLineDash([]);
  if (jump.apex_height_m !== null) {
    context.fillStyle = colour(jump.excluded ? "bad" : "good");
    context.beginPath();
    context.arc(axes.x(jump.at_s), axes.y(jump.apex_height_m * 1000), 5, 0, 7);
    context.fill();
  }
  context.restore();
  byId("number").textContent = `Jump ${jump.number} of ${log.jumps.length}`;
  const error = jump.se_m === null ? "" : ` ± ${(jump.se_m * 1000).toFixed(2)}`;
  byId("facts").textContent = jump.apex_height_m === null ? "no apex" : `apex ${(jump.apex_height_m * 1000).toFixed(2)}${error} mm at ${jump.at_s.toFixed(3)} s`;
  const doubts = doubtsOf(log, jump);
  byId("doubts").textContent = doubts.length ? `Look: ${doubts.join("; ")}.` : "";
  const verdict = byId("verdict");
  verdict.className = `verdict ${jump.decided?.verdict ?? ""}`;
  verdict.textContent = jump.decided
    ? `${jump.decided.verdict === "accept" ? "accepted" : `rejected: ${jump.decided.reason_code.replaceAll("_", " ")}`} by ${jump.decided.person}${jump.saved === false ? " (not saved yet)" : ""}`
    : "";
  status();
};

const move = (by) => {
  const log = here();
  if (!log) return;
  let { run, jump } = at;
  jump += by;
  if (jump >= log.jumps.length) { run += 1; jump = 0; }
  if (jump < 0) { run -= 1; jump = (loaded.get(runs[run])?.jumps.length ?? 1) - 1; }
  if (run < 0 || run >= runs.length) return;
  at = { run, jump };
  ahead();
  draw();
};

const show = (run, numbers, decided, saved) => {
  const log = loaded.get(run);
  if (!log) return;
  log.jumps.filter((jump) => numbers.includes(jump.number)).forEach((jump) => {
    counts.reviewed += (decided !== null) - (jump.decided !== null);
    Object.assign(jump, { decided, saved });
  });
};

const send = async () => {
  if (sending) return;
  sending = true;
  while (waiting.length) {
    try {
      const found = await post("/api/verdicts", waiting[0]);
      trouble = "";
      found.jumps.forEach((jump) => {
        show(jump.run, [jump.number], jump.decided, true);
        const drawn = loaded.get(jump.run)?.jumps.find((one) => one.number === jump.number);
        if (drawn) drawn.excluded = jump.excluded;
      });
      waiting.shift();
    } catch (error) {
      trouble = error.status ? error.message : "no answer: labbook is asked again";
      if (error.status && error.status !== 503) waiting.shift();
      else { sending = false; setTimeout(send, AGAIN_MS); break; }
    } finally {
      sessionStorage.setItem(WAITING, JSON.stringify(waiting));
      draw();
    }
  }
  sending = false;
};

const state = (numbers, verdict, reason, before) => {
  if (READ_ONLY) { trouble = "read-only: nothing is stated"; status(); return; }
  const run = runs[at.run];
  given.push({ at: { ...at }, run, before });
  waiting.push({ run, numbers, verdict, reason, blind: !open });
  sessionStorage.setItem(WAITING, JSON.stringify(waiting));
  show(run, numbers, verdict === "clear" ? null : { verdict, reason_code: reason, person: "you" }, false);
  send();
};
const decide = (verdict, reason) => {
  const jump = jumpHere();
  if (!jump) return;
  state([jump.number], verdict, reason, [{ number: jump.number, decided: jump.decided }]);
  move(1);
};
const undo = () => {
  const last = given.pop();
  if (!last) return;
  at = last.at;
  ahead();
  last.before.forEach(({ number, decided }) => {
    waiting.push({ run: last.run, numbers: [number], verdict: decided?.verdict ?? "clear", reason: decided?.reason_code ?? "other", blind: !open });
    show(last.run, [number], decided, false);
  });
  sessionStorage.setItem(WAITING, JSON.stringify(waiting));
  draw();
  send();
};
const acceptRest = () => {
  const log = here();
  if (!log) return;
  const rest = log.jumps.slice(at.jump).filter((jump) => !jump.decided && !doubtsOf(log, jump).length);
  if (!rest.length) return;
  state(rest.map((jump) => jump.number), "accept", "looks_right", rest.map((jump) => ({ number: jump.number, decided: jump.decided })));
  draw();
};
const goTo = (name) => {
  const run = runs.indexOf(name.trim());
  if (run < 0) { trouble = `there is no run ${name} with jumps`; status(); return; }
  trouble = "";
  at = { run, jump: 0 };
  ahead();
  draw();
};

const KEYS = {
  a: () => decide("accept", "looks_right"),
  r: () => byId("reasons").showModal(),
  u: undo,
  " ": () => move(1),
  ArrowRight: () => move(1),
  b: () => move(-1),
  ArrowLeft: () => move(-1),
  A: acceptRest,
  o: () => { open = !open; draw(); },
  g: () => { byId("goto").showModal(); byId("target").select(); },
  "?": () => byId("help").showModal(),
};
// Keys wait for the log of the next run, so that a burst of them loses none.
const pressed = [];
const work = () => {
  while (pressed.length && here()) {
    const key = pressed.shift();
    if (byId("reasons").open) document.querySelector(`#reasons [data-key="${CSS.escape(key)}"]`)?.click();
    else KEYS[key]?.();
  }
};
document.addEventListener("keydown", (event) => {
  const asked = document.querySelector("dialog[open]");
  if (event.ctrlKey || event.metaKey || event.altKey || (asked && asked.id !== "reasons")) return;
  if (!(asked ? document.querySelector(`#reasons [data-key="${CSS.escape(event.key)}"]`) : KEYS[event.key])) {
    if (pressed.length === 0 || event.key.length > 1) return;
  }
  event.preventDefault();
  pressed.push(event.key);
  work();
});
document.querySelectorAll(".keys button").forEach((button) => button.addEventListener("click", () => { button.blur(); KEYS[button.dataset.key](); }));
document.querySelectorAll("#reasons button").forEach((button) => button.addEventListener("click", () => {
  byId("reasons").close();
  decide("reject", button.dataset.reason);
}));
byId("goto").addEventListener("close", () => { if (byId("target").value) goTo(byId("target").value); });
new ResizeObserver(draw).observe(byId("jump"));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);

const found = await (await ask(`/api/queue${location.search}`)).json();
runs = found.runs;
Object.assign(counts, { jumps: found.jumps, reviewed: found.reviewed });
const first = new URLSearchParams(location.search).get("run");
if (first) at.run = Math.max(0, runs.indexOf(first));
ahead();
draw();
send();
