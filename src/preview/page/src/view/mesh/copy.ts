// A mesh as the frame that would make it again.

import type { BlockName } from "../../server/frame";
import type { DrawnSet } from "../../server/protocol";
import type { Cloth, Content } from "./cloth";
import type { ElementSet } from "./sets";

type Block = Float32Array | Uint32Array | Uint8Array | null | undefined;

export function contentOf(cloth: Cloth): Content {
  const { faces, values } = cloth;
  const blocks: Partial<Record<BlockName, Block>> = {
    points: Float32Array.from({ length: 3 * cloth.pointCount }, (_, at) => cloth.points[4 * Math.floor(at / 3) + (at % 3)]),
    faceCounts: faces.starts.subarray(1).map((end, face) => end - faces.starts[face]),
    facePoints: faces.corners,
    edges: faces.shown,
    faceOf: faces.owner,
    holes: holesOf(cloth),
    sources: cloth.sources,
    uvs: cloth.uvs,
    values: values?.numbers,
    elements: Uint32Array.from(cloth.sets.flatMap(({ elements }) => [...elements])),
  };
  const block = <Kind extends Block>(name: BlockName) => (blocks[name] ?? undefined) as Kind | undefined;
  const header = { leftHanded: cloth.handed < 0, sets: setsOf(cloth.sets), values: values && { ...values } };
  return { header, f32: block<Float32Array>, u32: block<Uint32Array>, u8: block<Uint8Array> };
}

function holesOf({ faceCount, triangles }: Cloth): Uint32Array {
  const drawn = new Set(triangles.faces);
  return Uint32Array.from([...Array(faceCount).keys()].filter((face) => !drawn.has(face)));
}

function setsOf(sets: ElementSet[]): DrawnSet[] {
  let offset = 0;
  return sets.map(({ name, kind, family, elements }) => {
    offset += elements.length;
    return { name, kind, family, offset: offset - elements.length, length: elements.length };
  });
}
