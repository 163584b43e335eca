// The pointer: drags move the camera, the wheel zooms, and what is left are clicks and places where it rests.

import type { PickHow } from "./api";

/** [CSS pixels] */
export interface Place {
  x: number;
  y: number;
}

export interface Gestures {
  /** `from` is where the drag began, as it may leave its column. */
  /** Whether a press begins a stroke here, which then has the pointer. */
  begin(at: Place, event: PointerEvent): boolean;
  stroke(at: Place): void;
  end(): void;
  orbit(dx: number, dy: number, from: Place): void;
  pan(dx: number, dy: number, from: Place): void;
  zoom(factor: number, at: Place): void;
  click(at: Place, how: PickHow): void;
  /** The pointer is here without a button, or has left. */
  rest(at: Place | null): void;
}

/** A press that moves farther is a drag. [CSS pixels] */
const SLACK = 4;

/** Returns a function that ends it. */
export function listen(canvas: HTMLCanvasElement, gestures: Gestures): () => void {
  const pressed = new Map<number, Place>();
  let start: Place | null = null;
  let dragging = false;
  let panning = false;
  let painting = false;
  const place = (event: MouseEvent): Place => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };

  const down = (event: PointerEvent): void => {
    canvas.setPointerCapture(event.pointerId);
    pressed.set(event.pointerId, place(event));
    start = place(event);
    dragging = pressed.size > 1;
    panning = event.button !== 0 || event.shiftKey;
    painting ||= event.button === 0 && pressed.size === 1 && gestures.begin(place(event), event);
  };

  const move = (event: PointerEvent): void => {
    const at = place(event);
    const before = pressed.get(event.pointerId);
    if (!before) {
      if (event.pointerType !== "touch") gestures.rest(at);
      return;
    }
    if (painting) return gestures.stroke(at);
    if (start && distance(start, at) > SLACK) dragging = true;
    if (!dragging) return;
    gestures.rest(null);
    if (pressed.size > 1) pinch(event.pointerId, at);
    else if (panning) gestures.pan(at.x - before.x, at.y - before.y, start ?? at);
    else gestures.orbit(at.x - before.x, at.y - before.y, start ?? at);
    pressed.set(event.pointerId, at);
  };

  const pinch = (id: number, at: Place): void => {
    const before = pressed.get(id);
    const other = [...pressed].find(([key]) => key !== id)?.[1];
    if (!before || !other) return;
    const middle = { x: (at.x + other.x) / 2, y: (at.y + other.y) / 2 };
    gestures.pan((at.x - before.x) / 2, (at.y - before.y) / 2, middle);
    gestures.zoom(distance(before, other) / Math.max(1, distance(at, other)), middle);
  };

  const up = (event: PointerEvent): void => {
    if (!pressed.delete(event.pointerId)) return;
    if (painting && pressed.size === 0) {
      painting = false;
      return gestures.end();
    }
    const at = place(event);
    const clicked = !dragging && event.type === "pointerup" && event.button === 0;
    if (pressed.size > 0) return;
    if (clicked) gestures.click(at, howOf(event));
    if (event.pointerType !== "touch" && event.type === "pointerup") gestures.rest(at);
  };

  const wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    const delta = Math.max(-240, Math.min(240, event.deltaY * lines));
    // A pinch on a touchpad arrives as a wheel with the control key, in small steps.
    gestures.zoom(Math.exp(delta * (event.ctrlKey ? 0.01 : 0.0016)), place(event));
  };

  const leave = (): void => {
    if (pressed.size === 0) gestures.rest(null);
  };

  const end = new AbortController();
  const { signal } = end;
  canvas.style.touchAction = "none";
  canvas.addEventListener("pointerdown", down, { signal });
  canvas.addEventListener("pointermove", move, { signal });
  canvas.addEventListener("pointerup", up, { signal });
  canvas.addEventListener("pointercancel", up, { signal });
  canvas.addEventListener("pointerleave", leave, { signal });
  canvas.addEventListener("wheel", wheel, { signal, passive: false });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
  return () => end.abort();
}

function howOf({ shiftKey, altKey, ctrlKey, metaKey }: PointerEvent): PickHow {
  if (ctrlKey || metaKey) return "path";
  if (altKey) return "remove";
  return shiftKey ? "add" : "replace";
}

function distance(a: Place, b: Place): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
