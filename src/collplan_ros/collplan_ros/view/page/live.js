// The live source: frames over a websocket of the page's own server, commands back.

const BEHIND = 0.09; // s that the picture is behind the newest frame, so that there are two to go between
const FASTEST_CATCH = 3; // 1/s
const JUMP = 0.5; // s: farther off, the picture jumps
const PATIENCE = 4000; // ms for an answer
const AGAIN = 1500; // ms between two attempts to connect

/** A source of frames that are of now. */
export function liveSource() {
  const token = document.querySelector("meta[name=token]").content;
  const waiting = new Map();
  let socket = null;
  let number = 0;
  let newest = NaN;
  let shown = NaN;
  let drawn = NaN;

  const source = {
    live: true,
    onframe: null,
    onreset: null,
    onstatus: null,

    now() {
      const moment = performance.now() / 1000;
      const passed = Number.isNaN(drawn) ? 0 : moment - drawn;
      drawn = moment;
      const error = newest - BEHIND - (shown + passed);
      if (Number.isNaN(shown) || !(Math.abs(error) < JUMP)) shown = newest - BEHIND;
      else shown += passed + error * Math.min(1, FASTEST_CATCH * passed);
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
    if (!(message.t < newest) || newest - message.t > JUMP) newest = message.t;
    source.onframe(message);
  }

  function connect() {
    let opened = false;
    socket = new WebSocket(`ws://${location.host}/frames`);
    socket.addEventListener("open", () => {
      opened = true;
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
  return source;
}
