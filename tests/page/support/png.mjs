// Reads PNG files of the browser: 8 bits, RGB or RGBA, not interlaced.

import assert from "node:assert/strict";
import { deflateSync, inflateSync } from "node:zlib";

/** Width, height, and rows of bytes. */
export function decode(png) {
  assert.equal(png.readUInt32BE(0), 0x89504e47, "a PNG");
  const data = [];
  let header = null;
  for (let at = 8; at < png.length;) {
    const length = png.readUInt32BE(at);
    const type = png.toString("latin1", at + 4, at + 8);
    const chunk = png.subarray(at + 8, at + 8 + length);
    if (type === "IHDR") header = chunk;
    if (type === "IDAT") data.push(chunk);
    at += 12 + length;
  }
  const [width, height, bits, colour] = [header.readUInt32BE(0), header.readUInt32BE(4), header[8], header[9]];
  assert.ok(bits === 8 && (colour === 2 || colour === 6) && header[12] === 0, "a kind of PNG that is known");
  const channels = colour === 6 ? 4 : 3;
  return { width, height, channels, pixels: unfiltered(inflateSync(Buffer.concat(data)), width, height, channels) };
}

function unfiltered(raw, width, height, channels) {
  const stride = width * channels;
  const out = Buffer.alloc(stride * height);
  for (let y = 0; y < height; y++) {
    const filter = raw[y * (stride + 1)];
    for (let x = 0; x < stride; x++) {
      const left = x >= channels ? out[y * stride + x - channels] : 0;
      const up = y > 0 ? out[(y - 1) * stride + x] : 0;
      const corner = x >= channels && y > 0 ? out[(y - 1) * stride + x - channels] : 0;
      out[y * stride + x] = raw[y * (stride + 1) + 1 + x] + predicted(filter, left, up, corner);
    }
  }
  return out;
}

function predicted(filter, left, up, corner) {
  if (filter === 1) return left;
  if (filter === 2) return up;
  if (filter === 3) return (left + up) >> 1;
  return filter === 4 ? paeth(left, up, corner) : 0;
}

function paeth(left, up, corner) {
  const [a, b, c] = [left, up, corner].map((each) => Math.abs(left + up - corner - each));
  if (a <= b && a <= c) return left;
  return b <= c ? up : corner;
}

/** Colour of a pixel as a number. */
function at({ width, channels, pixels }, x, y) {
  return pixels.readUIntBE((y * width + x) * channels, 3);
}

/** Red, green, blue of a pixel. */
export function rgb(image, x, y) {
  const colour = at(image, Math.min(x, image.width - 1), Math.min(y, image.height - 1));
  return [colour >> 16, (colour >> 8) & 255, colour & 255];
}

export function distance(a, b) {
  return Math.hypot(...a.map((value, i) => value - b[i]));
}

/** Share of the pixels between the columns `from` and `to` (as shares of the width) that differ by more than a distance. */
export function differing(a, b, [from, to] = [0, 1], least = 0) {
  assert.deepEqual([a.width, a.height], [b.width, b.height]);
  const [start, end] = [Math.floor(from * a.width), Math.floor(to * a.width)];
  let count = 0;
  const differ = (x, y) => at(a, x, y) !== at(b, x, y) && distance(rgb(a, x, y), rgb(b, x, y)) > least;
  for (let y = 0; y < a.height; y++) for (let x = start; x < end; x++) if (differ(x, y)) count += 1;
  return count / ((end - start) * a.height);
}

/** Different colours between two columns, which are many on a lit garment. */
export function colours(image, [from, to] = [0, 1]) {
  const found = new Set();
  for (let y = 0; y < image.height; y++) {
    for (let x = Math.floor(from * image.width); x < Math.floor(to * image.width); x++) found.add(at(image, x, y));
  }
  return found.size;
}

/** Share of the pixels between two columns that are not of the background, which is the same all over a row. */
export function inked(image, [from, to] = [0, 1]) {
  const [start, end] = [Math.floor(from * image.width), Math.floor(to * image.width)];
  let count = 0;
  for (let y = 0; y < image.height; y++) {
    const background = rgb(image, 1, y);
    for (let x = start; x < end; x++) if (distance(rgb(image, x, y), background) > 40) count += 1;
  }
  return count / ((end - start) * image.height);
}

/** Mean brightness, 0 to 255. */
export function brightness({ channels, pixels }) {
  let sum = 0;
  for (let i = 0; i < pixels.length; i += channels) sum += (pixels[i] + pixels[i + 1] + pixels[i + 2]) / 3;
  return (sum * channels) / pixels.length;
}

/** A PNG of colours that `colourAt` gives for x and y, from the upper left. */
export function encode(width, height, colourAt) {
  const rows = Array.from({ length: height }, (_, y) => [0, ...Array.from({ length: width }, (_, x) => colourAt(x, y)).flat()]);
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2, 0, 0, 0], 8);
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name, "latin1"), data]);
    const ends = Buffer.alloc(8);
    ends.writeUInt32BE(data.length, 0);
    ends.writeUInt32BE(crc32(body), 4);
    return Buffer.concat([ends.subarray(0, 4), body, ends.subarray(4)]);
  };
  const signature = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);
  const content = deflateSync(Buffer.from(rows.flat()));
  return Buffer.concat([signature, chunk("IHDR", header), chunk("IDAT", content), chunk("IEND", Buffer.alloc(0))]);
}

function crc32(bytes) {
  let rest = 0xffffffff;
  for (const byte of bytes) {
    rest ^= byte;
    for (let bit = 0; bit < 8; bit++) rest = rest & 1 ? (rest >>> 1) ^ 0xedb88320 : rest >>> 1;
  }
  return (rest ^ 0xffffffff) >>> 0;
}
