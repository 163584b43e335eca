// Binary frames.

import type { Blocks, MeshHeader } from "./protocol";

export type BlockName = keyof Blocks;

/** A decoded binary frame. */
export interface MeshFrame {
  header: MeshHeader;
  f32(name: BlockName): Float32Array | undefined;
  u32(name: BlockName): Uint32Array | undefined;
  u8(name: BlockName): Uint8Array | undefined;
  /** When the frame arrived. [ms since 1970] */
  received: number;
}
