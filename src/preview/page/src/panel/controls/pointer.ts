// A pointer that is pressed on a control and drags its value.

import type { TargetedMouseEvent, TargetedPointerEvent } from "preact";

/** Share of the way that a drag with Shift goes. */
const FINE = 0.1;

/** Follows the mouse until it is released. `moved` gets the way since the last time, and whether it is a fine one. [pixels] */
export function follow(
  press: TargetedPointerEvent<HTMLElement>,
  moved: (way: number, isFine: boolean) => void,
  ended?: () => void,
): void {
  const element = press.currentTarget;
  const controller = new AbortController();
  const { signal } = controller;
  let last = press.clientX;
  element.setPointerCapture(press.pointerId);
  const move = ({ clientX, shiftKey }: PointerEvent) => {
    const way = clientX - last;
    last = clientX;
    if (way !== 0) moved(shiftKey ? FINE * way : way, shiftKey);
  };
  element.addEventListener("pointermove", move, { signal });
  element.addEventListener("lostpointercapture", () => (controller.abort(), ended?.()), { signal });
}

/** Whether a press begins a drag here. Fingers scroll the panel, and have the browser's own sliders. */
export function drags({ button, pointerType }: PointerEvent): boolean {
  return button === 0 && pointerType === "mouse";
}

/** Keeps the browser from moving a slider or marking text with the mouse. */
export function ownMouse(event: TargetedMouseEvent<HTMLElement>): void {
  if (event.button === 0) event.preventDefault();
}
