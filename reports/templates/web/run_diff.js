// Two runs one over the other, time 0 at the lift-off of each one's first flight where both have one.
import { askJson, byId, colour, onChange, samplesOf } from "/static/common.js";
import { Axes, View, blocksOf, boxOf, drawLine, fitted, placeOf, rangeOf } from "/static/trace.js";

const canvas = byId("both");
const traceOf = async (run) => {
  const log = await askJson(`/api/runs/${encodeURIComponent(run)}/log`);
  const { time, height } = await samplesOf(run, log);
  const first = log.jumps.find((jump) => jump.lift_off_s !== null && jump.apex_height_m !== null);
  return { time, height, blocks: blocksOf(height), first };
};

const start = async () => {
  const traces = await Promise.all([canvas.dataset.first, canvas.dataset.second].map(traceOf));
  const flights = traces.map(({ first }) => first);
  const bothFly = flights.every(Boolean);
  traces.forEach((trace) => {
    const origin = bothFly ? trace.first.lift_off_s : trace.time[0];
    trace.time = trace.time.map((at) => at - origin);
  });
  const whole = [Math.min(...traces.map(({ time }) => time[0])), Math.max(...traces.map(({ time }) => time[time.length - 1]))];
  const ranges = traces.map(({ height }) => rangeOf(height));
  const heights = [Math.min(...ranges.map(([low]) => low)), Math.max(...ranges.map(([, high]) => high))];
  const looks = [["trace", 1.6, []], ["second", 1, [5, 3]]];
  const shown = new View(canvas, whole, (view) => {
    const { context, width, height: tall } = fitted(canvas);
    const axes = new Axes(boxOf(width, tall), view, heights);
    axes.draw(context, bothFly ? "time after the first lift-off (s)" : "time after the start of each log (s)", "body height (mm)");
    context.save();
    axes.clip(context);
    traces.forEach((trace, number) => {
      const [name, wide, dashes] = looks[number];
      context.strokeStyle = colour(name);
      context.lineWidth = wide;
      const from = Math.max(0, placeOf(trace.time, view[0]) - 1);
      const to = Math.min(trace.time.length, placeOf(trace.time, view[1]) + 1);
      context.setLineDash(to - from > 4 * axes.box.width ? [] : dashes);
      drawLine(context, axes, trace, from, to, trace.blocks);
    });
    context.restore();
  });
  if (bothFly) {  // the first flight of each at first; a double click shows all
    const longest = Math.max(...flights.map((jump) => 2 * (jump.at_s - jump.lift_off_s)));
    shown.show(-1.2 * longest, 2 * longest);
  }
};
if (canvas) await start();
onChange(() => location.reload());
