// Icons of 16 px with strokes of 1.5 px.

import type { ComponentChildren } from "preact";

const PATHS = {
  undo: "M6 3 2.5 6.5 6 10M3 6.5h6a4 4 0 0 1 0 8H6.5",
  redo: "m10 3 3.5 3.5L10 10m3-3.5H7a4 4 0 0 0 0 8h2.5",
  compare: "M8 1.5v13M6 3.5H3.5a1 1 0 0 0-1 1v7a1 1 0 0 0 1 1H6m4-9h2.5a1 1 0 0 1 1 1v7a1 1 0 0 1-1 1H10",
  sun: "M8 5.25a2.75 2.75 0 1 0 0 5.5 2.75 2.75 0 0 0 0-5.5ZM8 1.5v1m0 11v1m6.5-6.5h-1m-11 0h-1m11.1-4.6-.7.7m-7.8 7.8-.7.7m9.2 0-.7-.7M4.1 4.1l-.7-.7",
  moon: "M13.5 9.6A5.75 5.75 0 0 1 6.4 2.5a5.75 5.75 0 1 0 7.1 7.1Z",
  keys: "M2.5 4h11a1 1 0 0 1 1 1v6a1 1 0 0 1-1 1h-11a1 1 0 0 1-1-1V5a1 1 0 0 1 1-1ZM4 6.5h.01M6.7 6.5h.01M9.3 6.5h.01M12 6.5h.01M5 9.5h6",
  save: "M8 2v7.5m0 0L5 6.6m3 2.9 3-2.9M2.5 10v2.5a1 1 0 0 0 1 1h9a1 1 0 0 0 1-1V10",
  seam: "M2.5 13.5c4.5-.5 2-5 5.5-5.5s1-5 5.5-5.5",
  fold: "M2 4h8.5a2.75 2.75 0 0 1 0 5.5H2M2 12.5h5",
  plus: "M8 3v10M3 8h10",
  minus: "M3 8h10",
  brush: "M13.5 2.5 7 9m0 0C5 8 3.5 9.5 3.7 11.5 3.5 12.700 2.500 13.300 2 13.500c3 .5 6-.5 6.200-2.700C8.200 10 7.700 9.300 7 9Z",
  close: "m4 4 8 8m0-8-8 8",
  reset: "M3 8a5 5 0 1 0 1.6-3.7M4.5 1.8v2.7h2.7",
  reload: "M13.5 6.5A5.75 5.75 0 0 0 3 5M2.5 2v3.2h3.2M2.5 9.5A5.75 5.75 0 0 0 13 11M13.5 14v-3.2h-3.2",
  more: "M3.5 8h.01M8 8h.01M12.5 8h.01",
  down: "m4 6.5 4 4 4-4",
  right: "m6.5 4 4 4-4 4",
  up: "m4 9.5 4-4 4 4",
  handle: "M6 4h.01M10 4h.01M6 8h.01M10 8h.01M6 12h.01M10 12h.01",
  check: "m3 8.5 3.3 3.3L13 5",
  copy: "M6.5 5.5h6a1 1 0 0 1 1 1v6a1 1 0 0 1-1 1h-6a1 1 0 0 1-1-1v-6a1 1 0 0 1 1-1ZM3.5 10.5h-.5a.5.500 0 0 1-.5-.5V3.5a1 1 0 0 1 1-1H10a.5.500 0 0 1 .5.500v.5",
  large: "M2.5 3.5h7v9h-7zM11.5 3.5h2v3.5h-2zM11.5 9h2v3.5h-2z",
  side: "M2.5 3.5h4v9h-4zM9.5 3.5h4v9h-4z",
  over: "M2.5 2.5h7.5V10H2.5zM6 12.5v1h7.5V6h-1",
  wires: "M2.5 2.5h11v11h-11zM2.5 6.2h11M2.5 9.8h11M6.2 2.5v11M9.8 2.5v11",
  edgeSets: "M2.5 2.5h11v11h-11zM8 2.5v2M8 7v2M8 11.5v2",
  flat: "M2 4.5 6 3v8.5L2 13zM10 3l4 1.5V13l-4-1.5zM6 5.5h4",
  fabric: "M2.5 4.500h11M2.5 8h11M2.5 11.500h11M4.500 2.5v11M8 2.5v11M11.500 2.5v11",
  shadows: "M6.5 2.5a4 4 0 1 0 0 8 4 4 0 0 0 0-8ZM10.5 6.500a4 4 0 1 1-4 4.500M11 9l2 2M9.500 11l1.800 1.800",
  smooth: "M2 12.5C2 6.5 5 3.5 8 3.5s6 3 6 9M2 12.5h12M4.5 12.5 5.5 7M11.5 12.5l-1-5.5",
  eye: "M1.500 8C3 5 5.300 3.500 8 3.500S13 5 14.500 8C13 11 10.700 12.500 8 12.500S3 11 1.500 8ZM8 6a2 2 0 1 0 0 4 2 2 0 0 0 0-4Z",
  hidden: "M1.500 8C3 5 5.300 3.500 8 3.500S13 5 14.500 8C13 11 10.700 12.500 8 12.500S3 11 1.500 8ZM3 13 13 3",
  mirror: "M8 1.500v2M8 5.500v2M8 9.500v2M8 13.500v1M5.500 4.500 2 11.500h3.500zM10.500 4.500 14 11.500h-3.500z",
  isolate: "M6 5.5 8 4l2 1.5v5L8 12l-2-1.5zM2.5 4v-.500a1 1 0 0 1 1-1H4m8 0h.500a1 1 0 0 1 1 1V4m0 8v.500a1 1 0 0 1-1 1H12m-8 0h-.500a1 1 0 0 1-1-1V12",
  frame:
    "M2.5 5.5v-2a1 1 0 0 1 1-1h2m5 0h2a1 1 0 0 1 1 1v2m0 5v2a1 1 0 0 1-1 1h-2m-5 0h-2a1 1 0 0 1-1-1v-2M8 6.5a1.5 1.5 0 1 0 0 3 1.5 1.5 0 0 0 0-3Z",
  camera:
    "M2.5 5h2l1.2-1.7h4.6L11.5 5h2a1 1 0 0 1 1 1v6a1 1 0 0 1-1 1h-11a1 1 0 0 1-1-1V6a1 1 0 0 1 1-1ZM8 6.75a2.25 2.25 0 1 0 0 4.5 2.25 2.25 0 0 0 0-4.5Z",
  warning: "M8 2.2 14.3 13H1.7zM8 6.5v3M8 11.3v.01",
  error: "M8 1.8a6.2 6.2 0 1 0 0 12.4A6.2 6.2 0 0 0 8 1.8ZM8 5v3.5M8 10.9v.01",
  note: "M8 1.8a6.2 6.2 0 1 0 0 12.4A6.2 6.2 0 0 0 8 1.8ZM8 7.5V11M8 5.1v-.01",
  play: "M4.5 2.5v11l9-5.5z",
  pause: "M5 3v10M11 3v10",
  rename: "m10.5 3 2.5 2.5-7.5 7.5H3v-2.5zM9 4.5 11.5 7",
  trash: "M2.5 4.5h11M6 4.5v-2h4v2M4 4.5l.6 9h6.8l.6-9",
  search: "M7 2.5a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9ZM10.3 10.3l3.2 3.2",
} as const;

export type IconName = keyof typeof PATHS;

export function Icon({ name }: { name: IconName }) {
  const isDots = name === "handle" || name === "more";
  return (
    <Svg width={isDots ? 2 : 1.5} dash={name === "seam" ? "3 2.2" : undefined}>
      <path d={PATHS[name]} />
    </Svg>
  );
}

function Svg({ width, dash, children }: { width: number; dash?: string; children: ComponentChildren }) {
  return (
    <svg
      class="icon"
      width="16"
      height="16"
      viewBox="0 0 16 16"
      fill="none"
      stroke="currentColor"
      stroke-width={width}
      stroke-linecap="round"
      stroke-linejoin="round"
      stroke-dasharray={dash}
      aria-hidden="true"
    >
      {children}
    </svg>
  );
}
