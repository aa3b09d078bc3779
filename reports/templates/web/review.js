// Jumps one at a time, by keyboard. A key draws the next jump at once; its verdict is saved behind it, read back, and only
// then shown as saved. What the server did not take yet waits, in order, also over a reload of the page.
import { askJson, byId, colour, onChange, post, samplesOf } from "/static/common.js";
import { Axes, boxOf, drawLine, fitted, placeOf, rangeOf } from "/static/trace.js";

const READ_ONLY = document.body.dataset.readOnly === "yes";
const ME = document.body.dataset.person;
const [WAITING, PLACE, SEEN] = ["waiting", "place", "seen"].map((name) => `labbook-${document.body.dataset.book}-${name}`);
const SAID = { accept: "accepted", reject: "rejected", move: "moved", add: "added" };
const AHEAD = 8;
const LOGS = 60;
const AGAIN_MS = 1000;

const logs = new Map();
const loaded = new Map();
let queue = [];
let known = 0;  // the number of entries that the list was read with, and of what was stated here since
let at = 0;
let open = new URLSearchParams(location.search).has("open");
let given = [];
let waiting = JSON.parse(sessionStorage.getItem(WAITING) ?? "[]");
let sending = false;
let trouble = "";
let refused = "";  // what the server would not take, until the next key
let timer = null;
let quiet = null;
let latest = 0;  // the number of the last entry that the book is known to have
// Runs whose name or condition was seen here, for which no further verdict is blind.
const seen = new Set(JSON.parse(sessionStorage.getItem(SEEN) ?? "[]"));
const see = (run) => { seen.add(run); sessionStorage.setItem(SEEN, JSON.stringify([...seen])); };
if (new URLSearchParams(location.search).has("run")) see(new URLSearchParams(location.search).get("run"));
let placing = null;  // where a person is about to put an apex: { time, moves }
const counts = { reviewed: 0, rejected: 0 };

const logOf = (run) => {
  if (!logs.has(run)) {
    logs.set(run, (async () => {
      const log = await askJson(`/api/runs/${encodeURIComponent(run)}/log`);
      log.trace = await samplesOf(run, log);
      return log;
    })().catch((error) => { logs.delete(run); throw error; }));
  }
  return logs.get(run);
};
const ahead = () => {
  const runs = new Set(queue.slice(Math.max(at - 2, 0), at + AHEAD).map((one) => one.run));
  runs.forEach((run) => logOf(run).then((log) => { loaded.set(run, log); showWaiting(run); draw(); work(); }).catch((error) => { trouble = error.status ? error.message : "no answer from labbook"; status(); }));
  [...loaded.keys()].slice(0, -LOGS).filter((run) => !runs.has(run)).forEach((run) => { loaded.delete(run); logs.delete(run); });
};
const item = () => queue[at];
const here = () => loaded.get(item()?.run);
// A jump is named by its samples and the time at which it was found: numbers change when one is added.
const isOf = (one) => (other) => one.signal === other.signal && one.anchor_s === other.anchor_s;
const named = ({ signal, anchor_s }) => ({ signal, anchor_s });
const placeIn = (jump) => queue.findIndex((one) => one.run === jump.run && isOf(jump)(one));
const jumpHere = () => here()?.jumps.find(isOf(item()));
const blind = () => !open && !seen.has(item().run);
const shownVerdict = (jump) => (jump.decided && (open || [ME, "you"].includes(jump.decided.person)) ? jump.decided : null);

const status = () => {
  const parts = [`${counts.reviewed} of ${queue.length} reviewed`];
  if (counts.rejected) parts.push(`${counts.rejected} rejected`);
  if (waiting.length) parts.push(`${waiting.length} waiting to be saved`);
  if (trouble) parts.push(trouble);
  if (refused) parts.push(refused);
  byId("saved").textContent = parts.join(", ");
  byId("saved").className = trouble || refused ? "wrong" : "soft";
  const share = queue.length ? 100 * counts.reviewed / queue.length : 0;
  byId("share").style.width = `${share}%`;
  byId("share").parentElement.ariaValueNow = Math.round(share);
};

// What was recorded beside the height, as the leg's length, in a narrow strip below it.
const drawStrip = (context, time, { title, values }, view, [from, to], box) => {
  const [low, high] = rangeOf(values.subarray(from, to));
  if (!(low < high)) return;
  const axes = new Axes(box, view, [low, high]);
  context.save();
  context.font = "12px system-ui, sans-serif";
  context.fillStyle = colour("soft");
  context.textAlign = "right";
  context.textBaseline = "middle";
  axes.ys.forEach((end) => context.fillText(Math.round(end), box.left - 6, axes.y(end)));
  context.textAlign = "left";
  context.textBaseline = "bottom";
  context.fillText(title, box.left + 4, box.top + box.height + 14);
  axes.clip(context);
  context.strokeStyle = colour("soft");
  context.lineWidth = 1;
  drawLine(context, axes, { time, height: values }, from, to, null);
  context.restore();
};

// From the jump before to the one after: a missed one lies between them.
const betweenOthers = (log, jump) => {
  const place = log.jumps.indexOf(jump);
  const [before, after] = [log.jumps[place - 1], log.jumps[place + 1]];
  return [before ? before.at_s : jump.at_s - 4, after ? after.at_s + 0.3 : jump.at_s + 4];
};
const leftOut = (jump) => (jump.excluded && !jump.decided && jump.apex_height_m !== null ? `It does not count (${jump.excluded}); accepted, it does.` : "");

let drawn = null;
const draw = () => {
  const log = here();
  const jump = jumpHere();
  byId("title").textContent = item() ? (open ? `${item().run}${log ? `: ${log.title}` : ""}` : `Jump ${at + 1} of ${queue.length}`) : "Nothing to review";
  if (!log || !jump) {
    fitted(byId("jump"));
    ["number", "facts", "doubts", "verdict"].forEach((name) => { byId(name).textContent = ""; });
    status();
    return;
  }
  const { time, height } = log.trace;
  const next = log.jumps[log.jumps.indexOf(jump) + 1];
  const begin = jump.touchdown_s ?? jump.lift_off_s ?? jump.at_s - 0.4;
  const until = jump.at_s + (jump.apex_height_m === null ? 0.6 : 2.5 * (jump.at_s - begin));
  const end = next ? Math.min(until, next.touchdown_s ?? next.at_s) : until;
  const room = 0.15 * (end - begin);
  const view = placing && !placing.moves ? betweenOthers(log, jump) : [begin - room, end + room];
  if (placing && (placing.time < view[0] || placing.time > view[1])) {  // the view follows what is placed
    const shift = placing.time - (view[0] + view[1]) / 2;
    view[0] += shift;
    view[1] += shift;
  }
  const from = Math.max(0, placeOf(time, view[0]) - 1);
  const to = Math.min(time.length, placeOf(time, view[1]) + 1);
  let low = Infinity;
  let high = -Infinity;
  for (let place = from; place < to; place += 1) { low = Math.min(low, height[place]); high = Math.max(high, height[place]); }
  if (jump.apex_height_m !== null) high = Math.max(high, jump.apex_height_m);
  const spare = (high - low || 0.01) * 0.12;
  const { context, width, height: whole } = fitted(byId("jump"));
  const strip = 0.24 * whole;
  const tall = whole - strip * log.trace.beside.length;
  log.trace.beside.forEach((one, place) => drawStrip(context, time, one, view, [from, to], { ...boxOf(width, strip), top: tall + place * strip + 6, height: strip - 22 }));
  const axes = new Axes(boxOf(width, tall), view, [(low - spare) * 1000, (high + spare) * 1000]);
  axes.drawGaps(context, log.gaps);
  axes.draw(context, "time (s)", "body height (mm)");
  context.save();
  axes.clip(context);
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
    const roomLeft = side === "left" || axes.x(moment) - axes.box.left > 190;  // the axis has its name there
    context.textAlign = roomLeft ? side : "left";
    context.beginPath();
    context.moveTo(axes.x(moment), axes.box.top + 18);
    context.lineTo(axes.x(moment), axes.box.top + axes.box.height);
    context.stroke();
    context.fillText(roomLeft ? name : ` ${name}`, axes.x(moment), axes.box.top + (roomLeft ? 14 : 30));
  });
  context.setLineDash([]);
  if (jump.apex_height_m !== null) {
    context.fillStyle = colour(jump.excluded && (shownVerdict(jump) || !jump.decided) ? "bad" : "good");
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
  const placed = ["moved", "added"].filter((flag) => open && jump.flags.includes(flag)).map((flag) => `, ${flag} by a person`).join("");
  byId("facts").textContent = jump.apex_height_m === null ? "no apex" : `apex ${(jump.apex_height_m * 1000).toFixed(2)}${error} mm at ${jump.at_s.toFixed(3)} s${placed}`;
  const { doubts } = item();
  byId("doubts").textContent = placing
    ? `The apex at ${placing.time.toFixed(3)} s: click, or arrows and Enter; Escape leaves it as it is.`
    : [doubts.length ? `Look: ${doubts.join("; ")}.` : "", leftOut(jump)].join(" ").trim();
  const verdict = byId("verdict");
  const said = shownVerdict(jump);
  verdict.className = `verdict ${said?.verdict ?? ""}`;
  const why = said?.reason_code === "with_the_rest" ? " with the rest of its run" : said?.verdict === "reject" ? `: ${said.reason_code.replaceAll("_", " ")}` : "";
  const note = said?.note ? `, ${said.note},` : "";
  const earlier = jump.earlier.filter(({ person }) => !jump.decided && (open || person === ME))
    .map((one) => `${SAID[one.verdict]} by ${one.person}`).join(", ");
  verdict.textContent = !said && earlier ? `before the log or its reading changed: ${earlier}` : said ? `${SAID[said.verdict]}${why}${note} by ${said.person}${jump.saved === false ? " (not saved yet)" : ""}` : "";
  status();
};

// The place of the next jump without a verdict of one's own, from a place on and then from the first.
const nextOpen = (from) => {
  const after = queue.findIndex((one, place) => place >= from && !one.decided);
  return after >= 0 ? after : Math.max(queue.findIndex((one) => !one.decided), 0);
};
const stay = () => sessionStorage.setItem(PLACE, JSON.stringify({ search: location.search, run: item()?.run, ...named(item() ?? {}) }));
const move = (by) => {
  if (!queue[at + by]) return;
  at += by;
  if (open && item()) see(item().run);
  stay();
  ahead();
  draw();
};

const show = (run, jumps, decided, saved) => jumps.forEach((jump) => {
  queue.filter((one) => one.run === run && isOf(jump)(one)).forEach((one) => {
    const rejected = decided?.verdict === "reject";
    counts.reviewed += (decided !== null) - one.decided;
    counts.rejected += rejected - one.rejected;
    Object.assign(one, { decided: decided !== null, rejected });
  });
  loaded.get(run)?.jumps.filter(isOf(jump)).forEach((one) => Object.assign(one, { decided, saved }));
});

// What waits to be saved stands above what the server answered to an earlier statement.
const showSaid = ({ run, jumps, verdict, reason, note }) => show(run, jumps, verdict === "clear" ? null : { verdict, reason_code: reason, note, person: "you" }, false);
const showWaiting = (run) => waiting.filter((one) => one.run === run).forEach(showSaid);

const keep = () => sessionStorage.setItem(WAITING, JSON.stringify(waiting));
const later = () => { clearTimeout(timer); timer = setTimeout(send, AGAIN_MS); };
const send = async () => {
  if (sending) return;
  sending = true;
  while (waiting.length) {
    const [first] = waiting;
    try {
      const found = await post("/api/verdicts", first);
      trouble = "";
      if (found.entries - known <= found.jumps.length) known = found.entries;
      found.jumps.forEach((jump) => {
        show(found.run, [jump], jump.decided, true);
        loaded.get(found.run)?.jumps.filter(isOf(jump)).forEach((one) => { one.excluded = jump.excluded; });
      });
      waiting.shift();
      showWaiting(found.run);
    } catch (error) {
      trouble = error.status ? error.message : "no answer: labbook is asked again";
      if ([404, 409, 422].includes(error.status) && !error.message.includes("labbook.toml")) {  // it will never be taken
        refused = `not saved: ${first.verdict} of run ${first.run} (${error.message})`;
        trouble = "";
        see(first.run);
        waiting.shift();
        latest = Infinity;  // what stands instead is read anew
        soon();
      } else { later(); break; }
    } finally {
      keep();
      draw();
    }
  }
  sending = false;
};

const readOnly = () => { trouble = "read-only: nothing is stated"; status(); };
const state = (jumps, verdict, reason, before, note) => {
  if (READ_ONLY) { readOnly(); return; }
  const { run } = item();
  refused = "";
  given.push({ place: { run, ...named(item()) }, run, before, undo: { verdict, reason } });
  waiting.push({ run, jumps: jumps.map(named), verdict, reason, note, blind: blind() });
  keep();
  showSaid(waiting[waiting.length - 1]);
  send();
};
const decide = (verdict, reason, note) => {
  const jump = jumpHere();
  if (!jump) { refused = "this jump is not there any more: reload the page"; status(); return; }
  state([jump], verdict, reason, [{ jump: named(jump), decided: jump.decided }], note);
  move(1);
};
// Undone is one's own verdict; what somebody else had said stands no more, and is theirs to say again.
const undo = () => {
  refused = "";
  const last = given.pop();
  if (!last) { status(); return; }
  at = Math.max(placeIn(last.place), 0);
  stay();
  ahead();
  last.before.forEach(({ jump, decided }) => {
    const own = decided && [ME, "you"].includes(decided.person) && ["accept", "reject"].includes(decided.verdict) ? decided : null;
    waiting.push({ run: last.run, jumps: [jump], verdict: own?.verdict ?? "clear", reason: own?.reason_code ?? "other", note: own?.note, blind: blind(), undo: last.undo });
    show(last.run, [jump], own, false);
    if (decided && !own) refused = `${decided.person}'s verdict stood there before: it is for ${decided.person} to give again`;
  });
  keep();
  draw();
  send();
};
const acceptRest = () => {
  const { run } = item() ?? {};
  const rest = queue.filter((one) => one.run === run && !one.decided && !one.left_out && !one.doubts.length);
  if (!rest.length) return;
  state(rest, "accept", "with_the_rest", rest.map((one) => ({ jump: named(one), decided: null })));
  draw();
};
const goTo = (name) => {
  const place = queue.findIndex((one) => one.run === name.trim());
  if (place < 0) { trouble = `there is no run ${name} with jumps here`; status(); return; }
  trouble = "";
  see(name.trim());
  move(place - at);
};
const place = (moves) => {
  const jump = jumpHere();
  if (!jump || READ_ONLY) return;
  placing = { time: moves ? jump.at_s : (drawn.view[0] + drawn.view[1]) / 2, moves };
  draw();
};
const putApex = async () => {
  const { run, signal } = item();
  const { time, moves } = placing;
  const at_s = time - jumpHere().log_begins_s;
  placing = null;
  try {
    const found = await post("/api/apexes", { run, signal, jump: moves ? named(item()) : null, at_s, blind: blind() });
    sessionStorage.setItem(PLACE, JSON.stringify({ search: location.search, ...found }));
    location.reload();  // numbers of later jumps may be others now
  } catch (error) {
    see(run);  // the message names it
    trouble = error.status ? error.message : "no answer from labbook";
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

const MOVES = [" ", "b", "j", "ArrowRight", "ArrowLeft"];
const KEYS = {
  a: () => decide("accept", "looks_right"),
  r: () => (READ_ONLY ? readOnly() : byId("reasons").showModal()),
  u: undo,
  " ": () => move(1),
  ArrowRight: () => move(1),
  b: () => move(-1),
  j: () => move(nextOpen(at + 1) - at),
  ArrowLeft: () => move(-1),
  A: acceptRest,
  m: () => place(true),
  n: () => place(false),
  o: () => { if (item()) see(item().run); open = !open; draw(); },
  g: () => { byId("goto").showModal(); byId("target").select(); },
  "?": () => byId("help").showModal(),
};
// Keys wait for the log of the next run, so that a burst of them loses none; they go to the dialog that is open by then.
const TYPED = ["Enter", "Escape", "Backspace"];
const pressed = [];
const enter = (dialog, key) => {
  const input = dialog.querySelector("input");
  if (key === "Escape") dialog.close();
  else if (!input) dialog.querySelector(`[data-key="${CSS.escape(key)}"]`)?.click();
  else if (key === "Enter") input.form.requestSubmit();
  else if (key === "Backspace") input.value = input.value.slice(0, -1);
  else if (key.length === 1) input.setRangeText(key, input.selectionStart, input.selectionEnd, "end");
};
const work = () => {
  if (known && !queue.length) pressed.length = 0;  // there is nothing to judge
  while (queue.length && pressed.length && (here() || MOVES.includes(pressed[0]))) {
    const key = pressed.shift();
    const asked = document.querySelector("dialog[open]");
    if (asked) enter(asked, key);
    else if (placing) placeKey({ key });
    else KEYS[key]?.();
  }
};
document.addEventListener("keydown", (event) => {
  const asked = document.querySelector("dialog[open]");
  if (event.ctrlKey || event.metaKey || event.altKey || (asked && asked.id !== "reasons")) return;
  if (placing) { event.preventDefault(); placeKey(event); return; }
  if (event.repeat && !asked && !MOVES.includes(event.key)) { event.preventDefault(); return; }  // a key that is held says it once
  if (!(asked ? document.querySelector(`#reasons [data-key="${CSS.escape(event.key)}"]`) : KEYS[event.key])) {
    if (pressed.length === 0 || (event.key.length > 1 && !TYPED.includes(event.key))) return;
  }
  event.preventDefault();
  pressed.push(event.key);
  work();
});
document.querySelectorAll(".keys button").forEach((button) => button.addEventListener("click", () => { button.blur(); KEYS[button.dataset.key](); }));
document.querySelectorAll("#reasons button").forEach((button) => button.addEventListener("click", () => {
  byId("reasons").close();
  if (button.dataset.reason !== "other") { decide("reject", button.dataset.reason); return; }
  byId("note").value = "";
  byId("noting").showModal();
}));
// What is asked for is done at "submit": a dialog's "close" comes after further keys.
byId("noting").addEventListener("submit", () => decide("reject", "other", byId("note").value.trim() || undefined));
byId("goto").addEventListener("submit", () => { if (byId("target").value) goTo(byId("target").value); });
new ResizeObserver(draw).observe(byId("jump"));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);

const asked = await askJson(`/api/queue${location.search}`);
queue = asked.jumps;
known = asked.entries;
latest = Math.max(latest, known);
const count = () => {
  counts.reviewed = queue.filter((one) => one.decided).length;
  counts.rejected = queue.filter((one) => one.rejected).length;
};
count();
waiting.forEach(showSaid);
const left = JSON.parse(sessionStorage.getItem(PLACE) ?? "{}");
at = left.search === location.search && placeIn(left) >= 0 ? placeIn(left) : nextOpen(0);
ahead();
draw();
send();
work();

// What others stated stands here once nothing is typed or under way: the list and its logs are read anew.
const busy = () => waiting.length || sending || placing || pressed.length || document.querySelector("dialog[open]");
function soon() { clearTimeout(quiet); quiet = setTimeout(look, AGAIN_MS); }
const look = async () => {
  if (latest <= known) return;
  if (busy()) { soon(); return; }
  const stated = given.length;
  const fresh = await askJson(`/api/queue${location.search}`).catch(() => null);
  if (!fresh || busy() || given.length !== stated) { soon(); return; }
  const shown = item();
  [known, latest] = [fresh.entries, fresh.entries];
  queue = fresh.jumps;
  count();
  logs.clear();
  loaded.clear();
  const place = shown ? placeIn(shown) : -1;
  at = place >= 0 ? place : Math.max(0, Math.min(at, queue.length - 1));
  ahead();
  draw();
};
onChange((now) => { latest = Math.max(latest, now); soon(); });
