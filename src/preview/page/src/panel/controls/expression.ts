// Numbers as artists type them: "1/2", "3 * 0,5", and for lengths "9 mm" or "0.35in".

import { neat } from "./numbers";

/** Metres of the units that a length may have. */
const METRES: Record<string, number> = { mm: 0.001, cm: 0.01, dm: 0.1, m: 1, in: 0.0254, '"': 0.0254, ft: 0.3048 };

/** Longer texts are no numbers that someone typed. */
const LONGEST = 100;

const TOKEN = /\s*(?:(\d+\.?\d*(?:e[+-]?\d+)?|\.\d+(?:e[+-]?\d+)?)|([a-z]+|")|([-+*/()]))/iy;

/**
 * The number of a text; null if it is not one. An empty text is 0, which is the automatic value of a length.
 * `metres` is the length of a mesh unit; null for what is no length, where units are not taken.
 */
export function evaluate(text: string, metres: number | null): number | null {
  const tokens = split(text.trim().replaceAll(",", "."));
  if (tokens === null) return null;
  if (tokens.length === 0) return 0;
  const reader = new Reader(tokens, metres);
  const value = reader.sum();
  return reader.isAtEnd && value !== null && Number.isFinite(value) ? neat(value) : null;
}

function split(text: string): string[] | null {
  if (text.length > LONGEST) return null;
  const tokens: string[] = [];
  TOKEN.lastIndex = 0;
  while (TOKEN.lastIndex < text.length) {
    const match = TOKEN.exec(text);
    if (!match) return null;
    tokens.push((match[1] ?? match[2] ?? match[3]).toLowerCase());
  }
  return tokens;
}

class Reader {
  #at = 0;

  constructor(
    private readonly tokens: string[],
    private readonly metres: number | null,
  ) {}

  get isAtEnd(): boolean {
    return this.#at === this.tokens.length;
  }

  sum(): number | null {
    return this.#chain(["+", "-"], () => this.#product(), (a, b, sign) => (sign === "+" ? a + b : a - b));
  }

  #product(): number | null {
    return this.#chain(["*", "/"], () => this.#signed(), (a, b, sign) => (sign === "*" ? a * b : a / b));
  }

  #chain(
    signs: string[],
    next: () => number | null,
    join: (a: number, b: number, sign: string) => number,
  ): number | null {
    let value = next();
    for (let sign = this.#take(signs); value !== null && sign !== null; sign = this.#take(signs)) {
      const other = next();
      value = other === null ? null : join(value, other, sign);
    }
    return value;
  }

  #signed(): number | null {
    const sign = this.#take(["-", "+"]);
    const value = this.#take(["("]) === null ? this.#number() : this.#closed();
    const unit = value === null ? null : this.#unit();
    if (value === null || unit === null) return null;
    return (sign === "-" ? -1 : 1) * value * unit;
  }

  #closed(): number | null {
    const value = this.sum();
    return this.#take([")"]) === null ? null : value;
  }

  #number(): number | null {
    const token = this.tokens[this.#at];
    if (token === undefined || !/^[\d.]/.test(token)) return null;
    this.#at++;
    return Number(token);
  }

  /** The factor of a unit in mesh units, 1 without one; null where units are not taken. */
  #unit(): number | null {
    const token = this.tokens[this.#at];
    if (token === undefined || !/^[a-z"]/.test(token)) return 1;
    this.#at++;
    const size = Object.hasOwn(METRES, token) ? METRES[token] : null;
    return size === null || this.metres === null ? null : size / this.metres;
  }

  #take(signs: string[]): string | null {
    const token = this.tokens[this.#at];
    if (token === undefined || !signs.includes(token)) return null;
    this.#at++;
    return token;
  }
}
