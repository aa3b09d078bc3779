// One run: its trace, which zooms and moves, and all its jumps one over the other.
import { askJson, byId, colour, onChange, samplesOf } from "/static/common.js";
import { Axes, View, blocksOf, boxOf, drawLine, fitted, placeOf, rangeOf } from "/static/trace.js";

const canvas = byId("trace");

const markOf = (jump) => (jump.misfire ? "\u00d7" : jump.excluded ? "\u25cb" : "\u25cf");

const start = async () => {
  const run = canvas.dataset.run;
  let log = await askJson(`/api/runs/${encodeURIComponent(run)}/log`);
  const samples = await samplesOf(run, log);
  const { time, height } = samples;
  const blocks = blocksOf(height);
  const heights = rangeOf(height);
  const whole = [time[0], time[time.length - 1]];
  const draw = (view) => {
    const { context, width, height: tall } = fitted(canvas);
    const axes = new Axes(boxOf(width, tall), view, heights);
    axes.drawGaps(context, log.gaps);
    axes.draw(context, "time (s)", "body height (mm)");
    context.save();
    axes.clip(context);
    context.strokeStyle = colour("trace");
    context.lineWidth = 1;
    const from = Math.max(0, placeOf(time, view[0]) - 1);
    const to = Math.min(time.length, placeOf(time, view[1]) + 1);
    drawLine(context, axes, samples, from, to, blocks);
    context.textAlign = "center";
    context.textBaseline = "bottom";
    context.font = "11px system-ui, sans-serif";
    log.jumps.forEach((jump) => {
      if (jump.at_s < view[0] || jump.at_s > view[1]) return;
      const top = jump.apex_height_m === null ? axes.box.top + 14 : Math.max(axes.y(jump.apex_height_m * 1000) - 2, axes.box.top + 14);
      context.fillStyle = jump.excluded ? colour("bad") : colour("good");
      context.fillText(`${markOf(jump)}`, axes.x(jump.at_s), top);
      if (axes.box.width / (view[1] - view[0]) > 12) context.fillText(jump.number, axes.x(jump.at_s), top - 11);
    });
    context.restore();
  };
  const shown = new View(canvas, whole, draw);
  canvas.addEventListener("pointermove", (event) => {
    const place = Math.min(placeOf(time, shown.at(event)), time.length - 1);
    byId("at").textContent = `${time[place].toFixed(3)} s, ${(height[place] * 1000).toFixed(1)} mm`;
  });

  const drawOverlay = () => {
    const { context, width, height: tall } = fitted(byId("overlay"));
    const jumps = log.jumps.filter((jump) => jump.lift_off_s !== null && jump.apex_height_m !== null);
    if (!jumps.length) return;
    const longest = Math.max(...jumps.map((jump) => 2 * (jump.at_s - jump.lift_off_s)));
    const spans = [-0.3 * longest, 1.15 * longest];
    const flights = jumps.map((jump) => height.subarray(placeOf(time, jump.lift_off_s + spans[0]), placeOf(time, jump.lift_off_s + spans[1])));
    const ranges = flights.map(rangeOf);
    const axes = new Axes(boxOf(width, tall), spans, [Math.min(...ranges.map(([low]) => low)), Math.max(...ranges.map(([, high]) => high))]);
    axes.draw(context, "time after lift-off (s)", "body height (mm)");
    context.save();
    axes.clip(context);
    context.globalAlpha = 0.55;
    jumps.forEach((jump, number) => {
      const first = placeOf(time, jump.lift_off_s + spans[0]);
      context.strokeStyle = jump.excluded ? colour("bad") : colour("trace");
      context.setLineDash(jump.excluded ? [3, 3] : []);
      context.beginPath();
      flights[number].forEach((high, place) => context.lineTo(axes.x(time[first + place] - jump.lift_off_s), axes.y(high * 1000)));
      context.stroke();
    });
    context.restore();
  };

  new ResizeObserver(drawOverlay).observe(byId("overlay"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawOverlay);
  onChange(async () => { log = await askJson(`/api/runs/${encodeURIComponent(run)}/log`); shown.again(); drawOverlay(); });
};

document.addEventListener("keydown", (event) => {
  if (event.target !== document.body) return;
  const link = { ArrowLeft: "before", ArrowRight: "after" }[event.key];
  if (link) byId(link)?.click();
});
if (canvas) await start();
