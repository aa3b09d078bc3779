// A trace on a canvas: of a million samples only the lowest and highest of each column of pixels are drawn.
import { colour } from "/static/common.js";

const BLOCK = 256;

export const fitted = (canvas) => {
  const ratio = devicePixelRatio || 1;
  const { width, height } = canvas.getBoundingClientRect();
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
};

// The first place in `times` that is not before `at`.
export const placeOf = (times, at) => {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < at) low = middle + 1; else high = middle;
  }
  return low;
};

// Lowest and highest value of each block of samples, so that a wide view need not look at every sample.
export const blocksOf = (values) => {
  const count = Math.ceil(values.length / BLOCK);
  const low = new Float32Array(count).fill(Infinity);
  const high = new Float32Array(count).fill(-Infinity);
  for (let place = 0; place < values.length; place += 1) {
    const block = (place / BLOCK) | 0;
    if (values[place] < low[block]) low[block] = values[place];
    if (values[place] > high[block]) high[block] = values[place];
  }
  return { low, high };
};

const niceStep = (span, most) => {
  const rough = span / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].map((times) => times * power).find((step) => step >= rough);
};

export class Axes {
  constructor(box, xs, ys) {
    Object.assign(this, { box, xs, ys });
  }

  x(value) { return this.box.left + (value - this.xs[0]) / (this.xs[1] - this.xs[0]) * this.box.width; }

  y(value) { return this.box.top + (1 - (value - this.ys[0]) / (this.ys[1] - this.ys[0])) * this.box.height; }

  draw(context, xLabel, yLabel) {
    const { left, top, width, height } = this.box;
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = colour("soft");
    context.strokeStyle = colour("tint");
    context.lineWidth = 1;
    const xStep = niceStep(this.xs[1] - this.xs[0], Math.max(2, width / 90));
    context.textAlign = "center";
    context.textBaseline = "top";
    const digits = Math.max(0, -Math.floor(Math.log10(xStep) + 1e-9));
    for (let at = Math.ceil(this.xs[0] / xStep) * xStep; at <= this.xs[1] + 1e-9; at += xStep) {
      context.beginPath();
      context.moveTo(this.x(at), top);
      context.lineTo(this.x(at), top + height);
      context.stroke();
      context.fillText((Math.abs(at) < xStep / 2 ? 0 : at).toFixed(digits).replace("-", "\u2212"), this.x(at), top + height + 4);
    }
    const yStep = niceStep(this.ys[1] - this.ys[0], Math.max(2, height / 45));
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (let at = Math.ceil(this.ys[0] / yStep) * yStep; at <= this.ys[1] + 1e-9; at += yStep) {
      context.beginPath();
      context.moveTo(left, this.y(at));
      context.lineTo(left + width, this.y(at));
      context.stroke();
      context.fillText(Math.round(at), left - 6, this.y(at));
    }
    context.textAlign = "right";
    context.textBaseline = "bottom";
    context.fillText(xLabel, left + width, top + height + 32);
    context.textAlign = "left";
    context.textBaseline = "top";
    context.fillText(yLabel, left + 4, top + 2);
  }

  // Before the axes, whose labels stand above them.
  drawGaps(context, gaps) {
    const { top, height } = this.box;
    context.save();
    this.clip(context);
    context.fillStyle = colour("gap");
    gaps.forEach((gap) => context.fillRect(this.x(gap.start_s), top, Math.max(1, this.x(gap.end_s) - this.x(gap.start_s)), height));
    context.restore();
  }

  clip(context) {
    context.beginPath();
    context.rect(this.box.left, this.box.top, this.box.width, this.box.height);
    context.clip();
  }
}

export const boxOf = (width, height) => ({ left: 44, top: 6, width: width - 52, height: height - 42 });

// Draw a stretch of samples, heights in mm; where columns hold many samples, their lowest and highest.
export const drawLine = (context, axes, samples, from, to, blocks) => {
  const { time, height } = samples;
  context.beginPath();
  if (to - from <= 4 * axes.box.width) {
    for (let place = from; place < to; place += 1) {
      if (Number.isNaN(height[place])) continue;
      context.lineTo(axes.x(time[place]), axes.y(height[place] * 1000));
    }
    context.stroke();
    return;
  }
  let place = from;
  while (place < to) {
    const column = Math.floor(axes.x(time[place]));
    let low = Infinity;
    let high = -Infinity;
    while (place < to) {
      const block = place / BLOCK;
      if (blocks && Number.isInteger(block) && place + BLOCK < to && axes.x(time[place + BLOCK]) < column + 1) {
        low = Math.min(low, blocks.low[block]);
        high = Math.max(high, blocks.high[block]);
        place += BLOCK;
        continue;
      }
      if (axes.x(time[place]) >= column + 1) break;
      const value = height[place];
      if (value < low) low = value;
      if (value > high) high = value;
      place += 1;
    }
    if (low <= high) {
      context.lineTo(column + 0.5, axes.y(low * 1000));
      context.lineTo(column + 0.5, axes.y(high * 1000));
    }
  }
  context.stroke();
};

export const rangeOf = (values) => {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  const room = (high - low || 0.01) * 0.06;
  return [(low - room) * 1000, (high + room) * 1000];
};

// Lets a canvas zoom by wheel and keys, and move by dragging and arrows, over `whole` = [from, to]; `draw` is told the view.
export class View {
  constructor(canvas, whole, draw) {
    Object.assign(this, { canvas, whole, now: [...whole], wanted: false, draw });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const at = this.at(event);
      const by = event.deltaY > 0 ? 1.25 : 0.8;
      this.show(at - (at - this.now[0]) * by, at + (this.now[1] - at) * by);
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (!event.buttons) return;
      const moved = event.movementX / boxOf(canvas.clientWidth, 100).width * (this.now[1] - this.now[0]);
      this.show(this.now[0] - moved, this.now[1] - moved);
    });
    canvas.addEventListener("dblclick", () => this.show(...whole));
    canvas.addEventListener("keydown", (event) => {
      const step = (this.now[1] - this.now[0]) / 5;
      const act = { ArrowLeft: [-step, -step], ArrowRight: [step, step], "+": [step, -step], "-": [-step, step] }[event.key];
      if (act) { event.preventDefault(); this.show(this.now[0] + act[0], this.now[1] + act[1]); }
    });
    new ResizeObserver(() => this.again()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.again());
  }

  // The time under the pointer.
  at(event) {
    const box = boxOf(this.canvas.clientWidth, this.canvas.clientHeight);
    return this.now[0] + (event.offsetX - box.left) / box.width * (this.now[1] - this.now[0]);
  }

  show(from, to) {
    const [first, last] = this.whole;
    const length = Math.min(Math.max(to - from, 0.05), last - first);
    const begin = Math.min(Math.max(from, first), last - length);
    this.now = [begin, begin + length];
    this.again();
  }

  again() {
    if (this.wanted) return;
    this.wanted = true;
    requestAnimationFrame(() => { this.wanted = false; this.draw(this.now); });
  }
}
