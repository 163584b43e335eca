/** Runs in a page of the server that is not the preview: `edit(options)` resolves with the render mesh's times. */
export async function connect() {
  const socket = new WebSocket(new URL("socket", location.href).href.replace("http", "ws"));
  socket.binaryType = "arraybuffer";
  await new Promise((resolve) => (socket.onopen = resolve));
  const send = (message) => socket.send(JSON.stringify(message));
  const headerOf = (data) =>
    JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, new DataView(data).getUint32(0, true))));
  const renderMesh = () =>
    new Promise((resolve) => {
      socket.onmessage = ({ data }) => {
        const header = typeof data === "string" ? null : headerOf(data);
        if (header?.role === "render") resolve(header);
      };
    });
  const first = renderMesh();
  send({ type: "view", roles: ["model", "sim", "render"], smooth: 0, uv: false, values: null });
  await first;
  let serial = 0;
  window.edit = async (edits) => {
    const start = performance.now();
    const mesh = renderMesh();
    serial += 1;
    send({ type: "edit", serial, gesture: String(serial), edits });
    const { build, encode } = (await mesh).times;
    return { total: performance.now() - start, work: build + encode };
  };
}
