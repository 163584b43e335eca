// The socket to the server: sends requests, decodes frames, and reconnects while the server is away.

import type { BlockName, MeshFrame } from "./frame";
import type { MeshHeader, PageMessage, ServerMessage } from "./protocol";

export interface Listener {
  message(message: ServerMessage): void;
  mesh(frame: MeshFrame): void;
  connected(is: boolean): void;
}

/** Wait between attempts to reconnect. [ms] */
const RETRY = 1000;

export class Connection {
  #socket: WebSocket | null = null;

  constructor(private readonly listener: Listener) {
    this.#open();
  }

  send(message: PageMessage): void {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(JSON.stringify(message));
  }

  #open(): void {
    // The page's own address ends in the secret and a slash.
    const address = new URL("socket", document.baseURI);
    address.protocol = "ws:";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.listener.connected(true);
    socket.onclose = () => {
      this.listener.connected(false);
      setTimeout(() => this.#open(), RETRY);
    };
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") this.listener.message(JSON.parse(data) as ServerMessage);
      else this.listener.mesh(decode(data as ArrayBuffer));
    };
    this.#socket = socket;
  }
}

/** A frame is the length of the header (u32, little-endian), the header as JSON padded to a multiple of four, blocks. */
export function decode(buffer: ArrayBuffer): MeshFrame {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length))) as MeshHeader;
  const start = 4 + length;
  const view = <T>(name: BlockName, make: new (b: ArrayBuffer, offset: number, length: number) => T): T | undefined => {
    const block = header.blocks[name];
    return block ? new make(buffer, start + block.offset, block.length) : undefined;
  };
  return {
    header,
    f32: (name) => view(name, Float32Array),
    u32: (name) => view(name, Uint32Array),
    u8: (name) => view(name, Uint8Array),
    received: performance.timeOrigin + performance.now(),
  };
}
