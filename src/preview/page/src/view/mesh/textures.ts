// Tables that shaders read: four channels, in rows of 1024.

import { BufferAttribute, DataTexture, FloatType, IntType, RGBAFormat, UnsignedByteType } from "three";
import type { TextureDataType } from "three";

const WIDTH = 1024;

export function floatTexture(count: number): DataTexture {
  return texture(new Float32Array(4 * WIDTH * rows(count)), WIDTH, FloatType);
}

export function byteTexture(count: number): DataTexture {
  return texture(new Uint8Array(4 * WIDTH * rows(count)), WIDTH, UnsignedByteType);
}

function rows(count: number): number {
  return Math.max(1, Math.ceil(count / WIDTH));
}

/** The arrays are kept, as a lost context needs them again. */
export function texture(data: Float32Array | Uint8Array, width: number, type: TextureDataType): DataTexture {
  const made = new DataTexture(data as Float32Array<ArrayBuffer>, width, data.length / 4 / width, RGBAFormat, type);
  made.needsUpdate = true;
  return made;
}

/** An attribute that stays integer in the shader. */
export function integers(array: Uint32Array | Uint8Array, size: number): BufferAttribute {
  const attribute = new BufferAttribute(array, size);
  attribute.gpuType = IntType;
  return attribute;
}
