// Classes of edges in the shaders.

export const HIDDEN = 0;
export const PLAIN = 1;
export const HIGHLIGHTED = 2;
/** Sets follow. */
export const FIRST_SET = 3;
/** The class has seven bits; the eighth says that one face only has the edge. */
export const BORDER = 128;
export const CLASSES = 128;
