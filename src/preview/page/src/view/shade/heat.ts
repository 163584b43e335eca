// The colours of values: viridis, as polynomials fitted by Matt Zucker. [sRGB]

export const HEAT: readonly (readonly [number, number, number])[] = [
  [0.2777273272, 0.0054073445, 0.3340998053],
  [0.1050930431, 1.4046135299, 1.3845901627],
  [-0.3308618287, 0.2148475595, 0.0950951630],
  [-4.6342304989, -5.7991009734, -19.3324409563],
  [6.2282699363, 14.1799333668, 56.6905526007],
  [4.7763849977, -13.7451453774, -65.3530326334],
  [-5.4354558559, 4.6458526122, 26.3124352496],
];

/** The colour of a value from 0, the least, to 1, the most. */
export function heatCss(t: number): string {
  const at = Math.min(1, Math.max(0, t));
  const channels = [0, 1, 2].map((channel) => HEAT.reduceRight((sum, term) => sum * at + term[channel], 0));
  return `rgb(${channels.map((value) => Math.round(255 * Math.min(1, Math.max(0, value)))).join(" ")})`;
}
