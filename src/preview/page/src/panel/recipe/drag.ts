// Drags a card to another place. The other cards make room while it moves, and it lands when it is let go.

import type { CSSProperties, HTMLAttributes } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

interface Drag {
  full: string;
  from: number;
  to: number;
  /** Way of the card since the start. [pixels] */
  way: number;
  /** Height of the card with the gap below it. [pixels] */
  height: number;
}

const GAP = 6;
/** Zone at both ends of the panel in which it scrolls. [pixels] */
const EDGE = 40;

type Handle = HTMLAttributes<HTMLElement>;

interface Dragging {
  handle(full: string): Handle;
  style(place: number): { class: string; style?: CSSProperties };
}

export function useDrag(list: { current: HTMLElement | null }, drop: (full: string, to: number) => void): Dragging {
  const [drag, setDrag] = useState<Drag | null>(null);
  const end = useRef<(() => void) | null>(null);
  useEffect(() => () => end.current?.(), []);

  const start = (full: string, event: PointerEvent) => {
    if (event.button !== 0 || !list.current) return;
    event.preventDefault();
    end.current?.();
    end.current = follow(
      list.current,
      full,
      event,
      setDrag,
      (last) => last && last.to !== last.from && drop(full, last.to),
    );
  };

  return {
    handle: (full) => ({ onPointerDown: (event: PointerEvent) => start(full, event) }),
    style: (place) => styleOf(drag, place),
  };
}

function styleOf(drag: Drag | null, place: number): ReturnType<Dragging["style"]> {
  if (!drag) return { class: "" };
  if (place === drag.from) return { class: "is-dragged", style: { transform: `translateY(${drag.way}px)` } };
  const isBetween = place > Math.min(drag.from, drag.to - 0.5) && place < Math.max(drag.from, drag.to + 0.5);
  const way = isBetween ? Math.sign(drag.from - drag.to) * drag.height : 0;
  return { class: "makes-room", style: { transform: `translateY(${way}px)` } };
}

/** How far the pointer is in the zone that it moves towards. A card may be grabbed in a zone, which scrolls nothing yet. */
function beyond({ top, bottom }: DOMRect, pointer: number, start: number): number {
  return pointer < start ? Math.min(0, pointer - top - EDGE) : Math.max(0, pointer - Math.max(start, bottom - EDGE));
}

/** Follows the pointer until it is released; returns what ends it early. */
function follow(
  list: HTMLElement,
  full: string,
  event: PointerEvent,
  show: (drag: Drag | null) => void,
  done: (last: Drag | null) => void,
): () => void {
  const cards = [...list.querySelectorAll<HTMLElement>("[data-card]")];
  const boxes = cards.map((card) => card.getBoundingClientRect());
  const from = cards.findIndex((card) => card.dataset.card === full);
  const scroller = list.closest<HTMLElement>(".recipe-scroll");
  const startScroll = scroller?.scrollTop ?? 0;
  let pointer = event.clientY;
  let last: Drag | null = null;
  let frame = 0;

  const move = () => {
    const way = pointer - event.clientY + (scroller?.scrollTop ?? 0) - startScroll;
    const middle = boxes[from].top + boxes[from].height / 2 + way;
    const to = boxes.filter((box, i) => i !== from && box.top + box.height / 2 < middle).length;
    last = { full, from, to, way, height: boxes[from].height + GAP };
    show(last);
  };
  const scroll = () => {
    const box = scroller?.getBoundingClientRect();
    const over = box ? beyond(box, pointer, event.clientY) : 0;
    if (scroller && over !== 0) {
      scroller.scrollTop += over / 4;
      move();
    }
    frame = requestAnimationFrame(scroll);
  };
  const moved = (next: PointerEvent) => {
    pointer = next.clientY;
    move();
  };
  const stop = () => {
    cancelAnimationFrame(frame);
    controller.abort();
    show(null);
  };
  const controller = new AbortController();
  const { signal } = controller;
  addEventListener("pointermove", moved, { signal });
  addEventListener("pointercancel", stop, { signal });
  addEventListener("pointerup", () => (stop(), done(last)), { signal });
  addEventListener("keydown", ({ key }) => key === "Escape" && stop(), { signal });
  frame = requestAnimationFrame(scroll);
  return stop;
}
