// Small plots of the last seconds.

import { element } from "./dom.js";
import { firstAfter } from "./geometry.js";

const SHOWN = 20; // s
const GAP = 1; // s without a figure, over which no line is drawn

function nice(value) {
  const power = 10 ** Math.floor(Math.log10(Math.max(value, 1e-9)));
  return [1, 1.5, 2, 3, 5, 7.5, 10].map((each) => each * power).find((each) => each >= value);
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

  draw(lines, now, colors) {
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
    const shown = lines.map(({ name, points }) => {
      const begin = Math.max(0, firstAfter(points, now - SHOWN) - 1);
      return { name, points: points.slice(begin, firstAfter(points, now)) };
    });
    const values = shown.flatMap(({ points }) => points.map(({ value }) => value));
    const [least, most] = [Math.min(0, ...values), Math.max(0, ...values)];
    const bottom = least < 0 ? -nice(-least) : 0;
    const top = most > 0 ? nice(most) : least < 0 ? 0 : 1;
    const [left, right, high, low] = [34, width - 2, 5, height - 5];
    const sx = (t) => left + ((t - now + SHOWN) / SHOWN) * (right - left);
    const sy = (value) => low - ((value - bottom) / (top - bottom)) * (low - high);
    this.drawAxis(ctx, [bottom, (bottom + top) / 2, top], sy, left, right, colors);
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

/** All plots, of a scene. */
export class Plots {
  constructor(parent, scene) {
    this.scene = scene;
    this.speed = new Plot(parent, "speed", "m/s", 2);
    this.distance = new Plot(parent, "distance to the goal", "m", 2);
    this.planning = new Plot(parent, "planning time", "ms", 0);
    this.period = new Plot(parent, "control period", "ms", 0);
    this.terms = new Plot(parent, "cost of the choice", "", 2);
  }

  draw(now, colors) {
    const { track, series } = this.scene;
    const speed = [];
    for (let i = firstAfter(track, now - SHOWN - 1); i < track.length; i += 1) {
      const { t, vx } = track[i];
      if (vx !== undefined) speed.push({ t, value: track[i].speed / 1000 });
    }
    this.speed.draw([{ name: "speed", points: speed }], now, colors);
    this.distance.draw([{ name: "distance", points: series.distance }], now, colors);
    this.planning.draw([{ name: "planning", points: series.planning }], now, colors);
    this.period.draw([{ name: "period", points: series.period }], now, colors);
    const terms = [...series.terms].filter(([, points]) => points.length && points.at(-1).t > now - SHOWN);
    terms.sort(([a], [b]) => (b === "total") - (a === "total"));
    this.terms.draw(terms.map(([name, points]) => ({ name, points })), now, colors);
  }
}
