// Colours that the colour-blind can tell apart (Okabe and Ito 2008), and shapes and dashes beside them.

const LIGHT = {
  back: "#e9edf2", floor: "#ffffff", solid: "#c9d1db", edge: "#46566b", grid: "#eef1f5", text: "#1b2633",
  muted: "#66758a", free: "rgba(0,158,115,0.13)", freeEdge: "#009e73", frontier: "#0072b2", predicted: "#6a3d9a",
  remembered: "#5b6675", inferred: "rgba(70,86,107,0.16)", scan: "#d0175f", contact: "#d55e00",
  robot: "#222c3a", ring: "#e69f00", heading: "#ffffff", goal: "#00855f", deliberate: "#d55e00",
  mover: "#56708f", found: "#cc79a7", foreseen: "#e69f00", other: "#111111", outline: "#ffffff", plotLine: "#0072b2", plotGrid: "#dde3ea",
};
const DARK = {
  back: "#0b0f14", floor: "#151b23", solid: "#303b49", edge: "#8898ad", grid: "#1d252f", text: "#e4ebf3",
  muted: "#8e9db0", free: "rgba(0,190,140,0.14)", freeEdge: "#1fc796", frontier: "#56b4e9", predicted: "#c9a4f2",
  remembered: "#a7b4c4", inferred: "rgba(167,180,196,0.16)", scan: "#ff5c93", contact: "#ff8a3c",
  robot: "#0a0e13", ring: "#f5b52e", heading: "#ffffff", goal: "#2fd6a2", deliberate: "#ff8a3c",
  mover: "#9fd4ff", found: "#e8a3c8", foreseen: "#f5b52e", other: "#ffffff", outline: "#0b0f14", plotLine: "#56b4e9", plotGrid: "#29333f",
};
const TERM_LIGHT = ["#111111", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8860b", "#56b4e9", "#6a3d9a"];
const TERM_DARK = ["#ffffff", "#56b4e9", "#ff8a3c", "#1fc796", "#e8a3c8", "#f0e442", "#9fd4ff", "#c9a4f2"];
// plasma: its lightness rises all the way, so that it is read without colours too
const SPEED = ["#0d0887", "#5c01a6", "#9c179e", "#cc4778", "#ed7953", "#fdb42f", "#f0f921"];
const COST_LIGHT = ["#08306b", "#2171b5", "#6baed6", "#c6dbef"];
const COST_DARK = ["#e6f3ff", "#7fbdf0", "#3d7fb5", "#1d3f5e"];

const numbers = new Map();

function channels(color) {
  if (!numbers.has(color)) numbers.set(color, [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16)));
  return numbers.get(color);
}

function ramp(stops, share) {
  const at = Math.min(0.9999, Math.max(0, Number.isFinite(share) ? share : 0)) * (stops.length - 1);
  const low = Math.floor(at);
  const [a, b] = [channels(stops[low]), channels(stops[low + 1])];
  return `rgb(${a.map((value, i) => Math.round(value + (at - low) * (b[i] - value))).join(",")})`;
}

/** The colours of a theme. */
export class Colors {
  constructor(dark) {
    Object.assign(this, dark ? DARK : LIGHT);
    this.dark = dark;
    this.terms = dark ? TERM_DARK : TERM_LIGHT;
  }

  /** Colour of a speed as a share of the highest; its dark end is not used on dark ground, nor its light one on light. */
  speed(share) {
    const clipped = Math.min(1, Math.max(0, share));
    return ramp(SPEED, this.dark ? 0.22 + 0.78 * clipped : 0.86 * clipped);
  }

  /** Colour of a cost by its rank, from the cheapest at 0 to the dearest at 1. */
  cost(share) {
    return ramp(this.dark ? COST_DARK : COST_LIGHT, share);
  }
}
