// The size of the checker's squares.

/** Squares along the breadth of the UVs, about. */
const ALONG = 32;

/** The round length (1, 2 or 5 times a power of ten) that is nearest to `ALONG` squares over a length. [the same unit] */
export function squareOf(length: number): number {
  return roundLength(length / ALONG);
}

/** The nearest length of 1, 2 or 5 times a power of ten. */
export function roundLength(length: number): number {
  const power = 10 ** Math.floor(Math.log10(length));
  const all = [1, 2, 5, 10].map((factor) => Number((factor * power).toPrecision(6)));
  const far = (each: number) => Math.abs(Math.log(each / length));
  return all.reduce((best, each) => (far(each) < far(best) ? each : best));
}
