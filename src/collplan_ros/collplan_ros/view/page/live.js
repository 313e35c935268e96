// The live source: frames over a websocket of the page's own server, commands back.

const BEHIND = 0.09; // s that the picture is behind the newest frame, so that there are two to go between
const FASTEST_CATCH = 3; // 1/s
const JUMP = 0.5; // s: farther off, the picture jumps
const PACED = 2; // s over which the pace of the frames is measured, which is that of a simulation
const SLOWEST_PACE = 0.2; // s that have to pass for it
const PATIENCE = 4000; // ms for an answer
const AGAIN = 1500; // ms between two attempts to connect
const SILENT = 1.5; // s without a frame, of which at least one a second is sent: what is seen is then old
const LOOK = 250; // ms between two looks whether frames come

/** A source of frames that are of now. */
export function liveSource() {
  const token = document.querySelector("meta[name=token]").content;
  const waiting = new Map();
  let socket = null;
  let number = 0;
  let newest = NaN;
  let shown = NaN;
  let drawn = NaN;
  let came = []; // moments and times of the newest frames
  let heard = NaN; // moment of the newest frame, or of the connection where there is none
  let told = false; // whether it is shown that none arrives

  // seconds of the frames' clock that pass in one
  function pace() {
    const [first, last] = [came[0], came[came.length - 1]];
    return came.length && last.moment - first.moment > SLOWEST_PACE ? (last.t - first.t) / (last.moment - first.moment) : 1;
  }

  const source = {
    live: true,
    runs: [{ first: -Infinity, last: Infinity }],
    onframe: null,
    onreset: null,
    onstatus: null,

    now() {
      const moment = performance.now() / 1000;
      const passed = Number.isNaN(drawn) ? 0 : moment - drawn;
      drawn = moment;
      const rate = pace();
      const target = newest - BEHIND * rate;
      const error = target - (shown + rate * passed);
      if (Number.isNaN(shown) || !(Math.abs(error) < JUMP * Math.max(1, rate))) shown = target;
      else shown += rate * passed + error * Math.min(1, FASTEST_CATCH * passed);
      shown = Math.min(shown, newest);
      return Number.isNaN(shown) ? 0 : shown;
    },

    send(command) {
      if (!socket || socket.readyState !== WebSocket.OPEN) {
        return Promise.resolve({ ok: false, text: "not connected: nothing was sent" });
      }
      number += 1;
      const mine = number;
      socket.send(JSON.stringify({ ...command, number: mine, token }));
      return new Promise((resolve) => {
        waiting.set(mine, resolve);
        setTimeout(() => answer(mine, false, "no answer"), PATIENCE);
      });
    },
  };

  function answer(which, ok, text) {
    waiting.get(which)?.({ ok, text });
    waiting.delete(which);
  }

  function take(message) {
    if ("answer" in message) {
      answer(message.answer, message.done, message.text);
      return;
    }
    if (newest - message.t > JUMP) came = [];
    if (!(message.t < newest) || newest - message.t > JUMP) newest = message.t;
    const moment = performance.now() / 1000;
    if (told) source.onstatus("", false);
    told = false;
    heard = moment;
    came.push({ moment, t: newest });
    while (came[0].moment < moment - PACED) came.shift();
    source.onframe(message);
  }

  // a connection that hangs, and a view_node that does, close nothing
  function look() {
    const silence = performance.now() / 1000 - heard;
    if (socket?.readyState !== WebSocket.OPEN || !(silence > SILENT)) return;
    told = true;
    source.onstatus(`nothing from view_node for ${Math.floor(silence)} s: what you see is old`, true);
  }

  function connect() {
    let opened = false;
    socket = new WebSocket(`ws://${location.host}/frames`);
    socket.addEventListener("open", () => {
      opened = true;
      heard = performance.now() / 1000;
      source.onstatus("", false);
    });
    socket.addEventListener("message", (event) => take(JSON.parse(event.data)));
    socket.addEventListener("close", () => {
      waiting.forEach((_, which) => answer(which, false, "the connection was lost"));
      source.onstatus("not connected to view_node: what you see is old, and no button does anything", true);
      setTimeout(opened ? reload : connect, AGAIN);
    });
  }

  // a view_node that was started again has another token, and perhaps another page
  async function reload() {
    try {
      const page = await fetch("/", { cache: "no-store" });
      if (page.ok) location.reload();
    } catch {
      // not there yet
    }
    setTimeout(reload, AGAIN);
  }

  setTimeout(connect, 0);
  setInterval(look, LOOK);
  return source;
}
