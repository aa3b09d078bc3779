// Jumps one at a time, by keyboard. A key draws the next jump at once; its verdict is saved behind it, read back, and only
// then shown as saved. What the server did not take yet waits, in order, also over a reload of the page.
import { askJson, byId, colour, post, samplesOf } from "/static/common.js";
import { Axes, boxOf, drawLine, fitted, placeOf } from "/static/trace.js";

const READ_ONLY = document.body.dataset.readOnly === "yes";
const [WAITING, PLACE] = ["labbook-waiting", "labbook-place"];
const AHEAD = 8;
const LOGS = 60;
const AGAIN_MS = 1000;

const logs = new Map();
const loaded = new Map();
let queue = [];
let at = 0;
let open = new URLSearchParams(location.search).has("open");
let given = [];
let waiting = JSON.parse(sessionStorage.getItem(WAITING) ?? "[]");
let sending = false;
let trouble = "";
let placing = null;  // where a person is about to put an apex: { time, moves }
const counts = { reviewed: 0 };

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
const ahead = () => {
  const runs = new Set(queue.slice(Math.max(at - 2, 0), at + AHEAD).map((one) => one.run));
  runs.forEach((run) => logOf(run).then((log) => { loaded.set(run, log); draw(); work(); }).catch((error) => { trouble = error.message; status(); }));
  [...loaded.keys()].slice(0, -LOGS).filter((run) => !runs.has(run)).forEach((run) => { loaded.delete(run); logs.delete(run); });
};
const item = () => queue[at];
const here = () => loaded.get(item()?.run);
const jumpHere = () => here()?.jumps.find((jump) => jump.number === item().number);

const status = () => {
  const parts = [`${counts.reviewed} of ${queue.length} reviewed`];
  if (waiting.length) parts.push(`${waiting.length} waiting to be saved`);
  if (trouble) parts.push(trouble);
  byId("saved").textContent = parts.join(", ");
  byId("saved").className = trouble ? "wrong" : "soft";
  const share = queue.length ? 100 * counts.reviewed / queue.length : 0;
  byId("share").style.width = `${share}%`;
  byId("share").parentElement.ariaValueNow = Math.round(share);
};

let drawn = null;
const draw = () => {
  const log = here();
  const jump = jumpHere();
  byId("title").textContent = item() ? (open ? `${item().run}${log ? `: ${log.title}` : ""}` : `Jump ${at + 1} of ${queue.length}`) : "Nothing to review";
  if (!log || !jump) { status(); return; }
  const { time, height } = log.trace;
  const next = log.jumps[log.jumps.indexOf(jump) + 1];
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
  if (placing) {
    context.strokeStyle = colour("doubt");
    context.beginPath();
    context.moveTo(axes.x(placing.time), axes.box.top);
    context.lineTo(axes.x(placing.time), axes.box.top + axes.box.height);
    context.stroke();
  }
  context.restore();
  drawn = { axes, view, time };
  byId("number").textContent = `Jump ${jump.number} of ${log.jumps.length} in its run`;
  const error = jump.se_m === null ? "" : ` ± ${(jump.se_m * 1000).toFixed(2)}`;
  const placed = ["moved", "added"].filter((flag) => jump.flags.includes(flag)).map((flag) => `, ${flag} by a person`).join("");
  byId("facts").textContent = jump.apex_height_m === null ? "no apex" : `apex ${(jump.apex_height_m * 1000).toFixed(2)}${error} mm at ${jump.at_s.toFixed(3)} s${placed}`;
  const { doubts } = item();
  byId("doubts").textContent = placing
    ? `The apex at ${placing.time.toFixed(3)} s: click, or arrows and Enter; Escape leaves it as it is.`
    : doubts.length ? `Look: ${doubts.join("; ")}.` : "";
  const verdict = byId("verdict");
  verdict.className = `verdict ${jump.decided?.verdict ?? ""}`;
  verdict.textContent = jump.decided
    ? `${jump.decided.verdict === "accept" ? "accepted" : `rejected: ${jump.decided.reason_code.replaceAll("_", " ")}`} by ${jump.decided.person}${jump.saved === false ? " (not saved yet)" : ""}`
    : "";
  status();
};

const stay = () => sessionStorage.setItem(PLACE, JSON.stringify({ search: location.search, run: item()?.run, number: item()?.number }));
const move = (by) => {
  if (!queue[at + by]) return;
  at += by;
  stay();
  ahead();
  draw();
};

const show = (run, numbers, decided, saved) => {
  queue.filter((one) => one.run === run && numbers.includes(one.number)).forEach((one) => {
    counts.reviewed += (decided !== null) - one.decided;
    one.decided = decided !== null;
  });
  loaded.get(run)?.jumps.filter((jump) => numbers.includes(jump.number)).forEach((jump) => Object.assign(jump, { decided, saved }));
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
  const { run } = item();
  given.push({ at, run, before });
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
  stay();
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
  const { run } = item() ?? {};
  const rest = queue.filter((one) => one.run === run && !one.decided && !one.doubts.length);
  if (!rest.length) return;
  state(rest.map((one) => one.number), "accept", "looks_right", rest.map((one) => ({ number: one.number, decided: null })));
  draw();
};
const goTo = (name) => {
  const place = queue.findIndex((one) => one.run === name.trim());
  if (place < 0) { trouble = `there is no run ${name} with jumps here`; status(); return; }
  trouble = "";
  move(place - at);
};
const place = (moves) => {
  const jump = jumpHere();
  if (!jump || READ_ONLY) return;
  placing = { time: moves ? jump.at_s : (drawn.view[0] + drawn.view[1]) / 2, moves };
  draw();
};
const putApex = async () => {
  const { run, number } = item();
  const { time, moves } = placing;
  placing = null;
  try {
    const found = await post("/api/apexes", { run, number: moves ? number : null, at_s: time, blind: !open });
    sessionStorage.setItem(PLACE, JSON.stringify({ search: location.search, ...found }));
    location.reload();  // numbers of later jumps may be others now
  } catch (error) {
    trouble = error.message;
    draw();
  }
};
const placeKey = (event) => {
  const step = (event.shiftKey ? 10 : 1) * { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (step) {
    const now = placeOf(drawn.time, placing.time);
    placing.time = drawn.time[Math.min(Math.max(now + step, 0), drawn.time.length - 1)];
  } else if (event.key === "Enter") { putApex(); return; } else if (event.key === "Escape") placing = null;
  draw();
};
byId("jump").addEventListener("pointermove", (event) => {
  if (!placing || !drawn) return;
  const { box, xs } = drawn.axes;
  placing.time = xs[0] + (event.offsetX - box.left) / box.width * (xs[1] - xs[0]);
  draw();
});
byId("jump").addEventListener("click", () => { if (placing) putApex(); });

const KEYS = {
  a: () => decide("accept", "looks_right"),
  r: () => byId("reasons").showModal(),
  u: undo,
  " ": () => move(1),
  ArrowRight: () => move(1),
  b: () => move(-1),
  ArrowLeft: () => move(-1),
  A: acceptRest,
  m: () => place(true),
  n: () => place(false),
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
  if (placing) { event.preventDefault(); placeKey(event); return; }
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

queue = (await askJson(`/api/queue${location.search}`)).jumps;
counts.reviewed = queue.filter((one) => one.decided).length;
waiting.forEach(({ run, numbers, verdict, reason }) => show(run, numbers, verdict === "clear" ? null : { verdict, reason_code: reason, person: "you" }, false));
const left = JSON.parse(sessionStorage.getItem(PLACE) ?? "{}");
const known = queue.findIndex((one) => one.run === left.run && one.number === left.number);
if (left.search === location.search && known >= 0) at = known;
ahead();
draw();
send();
