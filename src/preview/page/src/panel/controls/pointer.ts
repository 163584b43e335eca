// A pointer that is pressed on a control and drags its value.

import type { TargetedMouseEvent, TargetedPointerEvent } from "preact";

/** Share of the way that a drag with Shift goes. */
const FINE = 0.1;

/** Follows the mouse until it is released. `moved` gets the way since the last time to the right, whether it is a fine one, and the
 *  way down. [pixels] */
export function follow(
  press: TargetedPointerEvent<HTMLElement>,
  moved: (way: number, isFine: boolean, down: number) => void,
  ended?: () => void,
): void {
  const element = press.currentTarget;
  const controller = new AbortController();
  const { signal } = controller;
  let [x, y] = [press.clientX, press.clientY];
  element.setPointerCapture(press.pointerId);
  const move = ({ clientX, clientY, shiftKey }: PointerEvent) => {
    const share = shiftKey ? FINE : 1;
    moved(share * (clientX - x), shiftKey, share * (clientY - y));
    [x, y] = [clientX, clientY];
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
