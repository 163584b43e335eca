// Pictures that are saved: larger than the canvas, without a ground, or all around the garment.

import { WebGLRenderTarget } from "three";
import type { WebGLRenderer } from "three";
import { Mean } from "./mean";
import { sampleAt, SAMPLES } from "./samples";
import type { Draw } from "./still";

/** Draws samples of a picture of a size in device pixels, on a clear ground. */
export async function clearPicture(renderer: WebGLRenderer, width: number, height: number, draw: Draw): Promise<Blob> {
  if (!Mean.fits(renderer) || Math.max(width, height) > renderer.capabilities.maxTextureSize) {
    throw new Error(`The graphics card cannot draw ${width} × ${height} pixels. Save this view instead.`);
  }
  const mean = new Mean(renderer, width, height);
  const target = new WebGLRenderTarget(width, height, { depthBuffer: false });
  for (let number = 0; number < SAMPLES; number++) {
    for (const _ of draw(mean, sampleAt(number)));
    mean.add();
  }
  mean.show(target);
  const pixels = new Uint8Array(4 * width * height);
  await renderer.readRenderTargetPixelsAsync(target, 0, 0, width, height, pixels);
  mean.dispose();
  target.dispose();
  return toPng(pixels, width, height);
}

/** Rows come from below, with colours times alpha. */
function toPng(pixels: Uint8Array, width: number, height: number): Promise<Blob> {
  const image = new ImageData(width, height);
  for (let y = 0; y < height; y++) {
    const from = 4 * width * (height - 1 - y);
    const row = image.data.subarray(4 * width * y, 4 * width * (y + 1));
    row.set(pixels.subarray(from, from + 4 * width));
    for (let at = 0; at < row.length; at += 4) {
      const alpha = row[at + 3];
      if (alpha === 0 || alpha === 255) continue;
      for (let channel = at; channel < at + 3; channel++) row[channel] = (255 * row[channel]) / alpha;
    }
  }
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d")?.putImageData(image, 0, 0);
  return canvas.convertToBlob({ type: "image/png" });
}

/** Pictures a second of a film at most. */
const RATE = 30;
/** Share of the film between two pictures at most: where drawing is slow, a film takes longer. */
const LONGEST_STEP = 1 / 48;
const BITS_PER_SECOND = 16_000_000;

/** Films a canvas. `draw` gets the share that is over, from 0 to 1, in each frame of animation. */
export async function film(canvas: HTMLCanvasElement, seconds: number, draw: (share: number) => void): Promise<Blob> {
  const type = ["video/webm;codecs=vp9", "video/webm;codecs=vp8"].find((type) => MediaRecorder.isTypeSupported(type));
  if (!type) throw new Error("The browser cannot record a film. Save pictures instead.");
  const recorder = new MediaRecorder(canvas.captureStream(RATE), { mimeType: type, videoBitsPerSecond: BITS_PER_SECOND });
  const parts: Blob[] = [];
  recorder.addEventListener("dataavailable", ({ data }) => parts.push(data));
  const ended = new Promise((resolve) => recorder.addEventListener("stop", resolve));
  recorder.start();
  let last = await frame();
  for (let share = 0; share < 1;) {
    draw(share);
    const now = await frame();
    share += Math.min((now - last) / (1000 * seconds), LONGEST_STEP);
    last = now;
  }
  recorder.stop();
  await ended;
  return new Blob(parts, { type: "video/webm" });
}

function frame(): Promise<number> {
  return new Promise(requestAnimationFrame);
}
