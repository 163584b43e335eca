/** Runs in the page before its own scripts: notes what its socket sends and gets, as `window.observed`. */
export function observe() {
  const observed = {
    /** Frames by role, those with points by role, and the header of the last one. */
    frames: { model: 0, sim: 0, render: 0 },
    headers: {},
    points: {},
    elements: {},
    messages: [],
    sent: [],
    /** Time of the last message in either direction. [ms] */
    last: performance.now(),
    sockets: [],
  };
  const note = (data) => {
    observed.last = performance.now();
    if (typeof data === "string") {
      observed.messages.push(JSON.parse(data));
      if (observed.messages.length > 2000) observed.messages.splice(0, 1000);
      return;
    }
    const length = new DataView(data).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    const block = (name, Kind) => {
      const at = header.blocks[name];
      return at && new Kind(data.slice(4 + length + at.offset, 4 + length + at.offset + 4 * at.length));
    };
    const { role } = header;
    observed.frames[role] += 1;
    observed.headers[role] = header;
    observed.points[role] = block("points", Float32Array) ?? observed.points[role];
    if (header.sets) observed.elements[role] = { sets: header.sets, numbers: block("elements", Uint32Array) };
  };
  window.observed = observed;
  window.WebSocket = class extends WebSocket {
    constructor(...args) {
      super(...args);
      observed.sockets.push(this);
      this.addEventListener("message", ({ data }) => note(data));
    }

    send(data) {
      observed.last = performance.now();
      observed.sent.push(JSON.parse(data));
      super.send(data);
    }
  };
}
