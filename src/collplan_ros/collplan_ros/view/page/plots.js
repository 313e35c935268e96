// Small plots of the last seconds.

import { element } from "./dom.js";
import { firstAfter } from "./geometry.js";

const SHOWN = 20; // s, or a whole run that is shorter
const GAP = 1; // s without a figure, over which no line is drawn
const LEGIBLE = 12; // px between two figures of an axis

function nice(value) {
  const power = 10 ** Math.floor(Math.log10(Math.max(value, 1e-9)));
  return [1, 1.6, 2, 3, 4, 6, 8, 10].map((each) => each * power).find((each) => each >= value);
}

/** One plot of lines [{name, points: [{t, value}, ...]}, ...]. */
class Plot {
  constructor(parent, title, unit, digits) {
    Object.assign(this, { unit, digits });
    this.box = element("div", parent, "plot");
    const head = element("div", this.box, "head");
    element("span", head).textContent = title;
    this.figure = element("b", head);
    this.canvas = element("canvas", this.box);
    this.names = element("div", this.box, "names");
    this.named = "";
  }

  draw(lines, [begin, end], now, colors) {
    const shown = lines.map(({ name, points }) => {
      const first = Math.max(0, firstAfter(points, begin) - 1);
      return { name, points: points.slice(first, firstAfter(points, now)) };
    });
    const values = shown.flatMap(({ points }) => points.map(({ value }) => value));
    this.box.hidden = !values.length;
    if (this.box.hidden) return;
    const { canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const ctx = canvas.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, width, height);
    const [least, most] = [Math.min(0, ...values), Math.max(0, ...values)];
    const bottom = least < 0 ? -nice(-least) : 0;
    const top = most > 0 ? nice(most) : least < 0 ? 0 : 1;
    const [left, right, high, low] = [34, width - 2, 5, height - 5];
    const sx = (t) => left + ((t - begin) / (end - begin)) * (right - left);
    const sy = (value) => low - ((value - bottom) / (top - bottom)) * (low - high);
    const middle = bottom < 0 && top > 0 ? 0 : (bottom + top) / 2;
    const ticks = [bottom, middle, top].filter((tick) => tick === middle || Math.abs(sy(tick) - sy(middle)) > LEGIBLE);
    this.drawAxis(ctx, ticks, sy, left, right, colors);
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, 0, right - left, height);
    ctx.clip();
    shown.forEach(({ points }, k) => this.drawLine(ctx, points, sx, sy, lines.length > 1 ? colors.terms[k % 8] : colors.plotLine));
    ctx.restore();
    this.write(shown, colors);
  }

  drawAxis(ctx, ticks, sy, left, right, colors) {
    ctx.font = "10px system-ui, sans-serif";
    ctx.textAlign = "right";
    ctx.textBaseline = "middle";
    ctx.lineWidth = 1;
    for (const tick of ticks) {
      ctx.strokeStyle = colors.plotGrid;
      ctx.beginPath();
      ctx.moveTo(left, sy(tick));
      ctx.lineTo(right, sy(tick));
      ctx.stroke();
      ctx.fillStyle = colors.muted;
      ctx.fillText(String(Number(tick.toPrecision(3))), left - 5, sy(tick));
    }
  }

  drawLine(ctx, points, sx, sy, color) {
    ctx.strokeStyle = color;
    ctx.lineWidth = 1.6;
    ctx.lineJoin = "round";
    ctx.beginPath();
    let last = -Infinity;
    for (const { t, value } of points) {
      if (t - last > GAP) ctx.moveTo(sx(t), sy(value));
      else ctx.lineTo(sx(t), sy(value));
      last = t;
    }
    ctx.stroke();
  }

  write(shown, colors) {
    const last = shown[0]?.points.at(-1)?.value;
    this.figure.textContent = last === undefined ? "–" : `${last.toFixed(this.digits)} ${this.unit}`;
    const names = shown.length > 1 ? shown.map(({ name }) => name.replaceAll("_", " ")) : [];
    const named = `${names.join()} ${colors.dark}`;
    if (named === this.named) return;
    this.named = named;
    this.names.replaceChildren();
    names.forEach((name, k) => {
      const item = element("span", this.names);
      element("i", item).style.background = colors.terms[k % 8];
      item.append(name);
    });
  }
}

/** All plots, of a scene: its last seconds, or those of a run that begins and ends. */
export class Plots {
  constructor(parent, scene, begin = -Infinity, end = Infinity) {
    this.scene = scene;
    this.begin = begin;
    this.span = Math.min(SHOWN, end - begin);
    const which = this.span < SHOWN ? "the whole run," : "the last";
    element("p", parent, "note", `${which} ${Number(this.span.toPrecision(2))} s`);
    this.speed = new Plot(parent, "speed", "m/s", 2);
    this.distance = new Plot(parent, "distance to the goal", "m", 2);
    this.planning = new Plot(parent, "planning time", "ms", 0);
    this.period = new Plot(parent, "control period", "ms", 0);
    this.terms = new Plot(parent, "cost of the choice", "", 2);
  }

  draw(now, colors) {
    const { track, series } = this.scene;
    const begin = Math.max(this.begin, now - this.span);
    const shown = [begin, begin + this.span];
    const speed = [];
    for (let i = firstAfter(track, begin - GAP); i < track.length; i += 1) {
      const { t, vx } = track[i];
      if (vx !== undefined) speed.push({ t, value: track[i].speed / 1000 });
    }
    this.speed.draw([{ name: "speed", points: speed }], shown, now, colors);
    this.distance.draw([{ name: "distance", points: series.distance }], shown, now, colors);
    this.planning.draw([{ name: "planning", points: series.planning }], shown, now, colors);
    this.period.draw([{ name: "period", points: series.period }], shown, now, colors);
    const terms = [...series.terms].filter(([, points]) => points.length && points.at(-1).t > begin);
    terms.sort(([a], [b]) => (b === "total") - (a === "total"));
    this.terms.draw(terms.map(([name, points]) => ({ name, points })), shown, now, colors);
  }
}
