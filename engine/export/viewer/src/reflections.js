// reflections.js - what shiny bodies mirror: the sky, which depends on the height above the horizon alone.
//
// three.js would draw the sky into a cube and filter it on the graphics card, 256 samples for each of 400,000 texels: seconds where the card
// is a program. A sky of one variable is filtered here, exactly, in milliseconds, into a cube of the same form (PMREMGenerator: GGX of
// roughness 0 in the largest level to 1 in the smallest that is used).
import { CubeTexture, DataTexture, DataUtils, HalfFloatType, LinearFilter, LinearMipmapLinearFilter, LinearSRGBColorSpace, RGBAFormat } from "three";

const SIZE = 64, LEVELS = 4, STEPS = 512;       // texels of a side; levels down to 8; values of the height in a table
const RADII = 16, TURNS = 8;                    // directions of a lobe

// Towards the texel at (s, t) of a face, -1 .. 1; x is turned round, as cubes that are not drawn are read.
const FACES = [
  (s, t) => [-1, -t, -s], (s, t) => [1, -t, s], (s, t) => [-s, 1, t], (s, t) => [-s, -1, -t], (s, t) => [-s, -t, 1], (s, t) => [s, -t, -1],
];

// Shares of what is above, of the rim and of what is below in the sky at a height: as its shader in scene.js.
const away = (h) => (1 - Math.min(1, Math.max(0, 1.3 * h))) ** 3;
const under = (h) => Math.min(1, Math.max(0, -6 * h));

// Directions of the GGX lobe about a normal that is looked along: [cosine, sine times the cosine of the turn, weight].
function lobe(roughness) {
  if (roughness === 0) return [[1, 0, 1]];
  const list = [], a2 = roughness ** 4;
  for (let i = 0; i < RADII; i++) {
    const u = (i + 0.5) / RADII, angle = 2 * Math.atan(Math.sqrt((a2 * u) / (1 - u))), c = Math.cos(angle), s = Math.sin(angle);
    for (let k = 0; c > 0 && k < TURNS; k++) list.push([c, s * Math.cos((2 * Math.PI * (k + 0.5)) / TURNS), c]);
  }
  return list;
}

// Half floats, four for each height from -1 to 1.
function table(sky, roughness) {
  const out = new Uint16Array(4 * (STEPS + 1)), directions = lobe(roughness), whole = directions.reduce((sum, d) => sum + d[2], 0);
  for (let i = 0; i <= STEPS; i++) {
    const h = (2 * i) / STEPS - 1, across = Math.sqrt(Math.max(0, 1 - h * h));
    let rim = 0, low = 0;
    for (const [c, s, weight] of directions) {
      const to = c * h + s * across, below = under(to), share = weight / whole;
      rim += share * away(to) * (1 - below);
      low += share * below;
    }
    ["r", "g", "b"].forEach((k, at) => { out[4 * i + at] = DataUtils.toHalfFloat(sky.top[k] * (1 - rim - low) + sky.rim[k] * rim + sky.low[k] * low); });
    out[4 * i + 3] = DataUtils.toHalfFloat(1);
  }
  return out;
}

function face(direction, size, up, values) {
  const data = new Uint16Array(4 * size * size);
  for (let y = 0, at = 0; y < size; y++) {
    for (let x = 0; x < size; x++, at += 4) {
      const [a, b, c] = direction((2 * x + 1) / size - 1, (2 * y + 1) / size - 1);
      const h = (a * up.x + b * up.y + c * up.z) / Math.hypot(a, b, c), i = 4 * Math.round(0.5 * STEPS * (h + 1));
      for (let k = 0; k < 4; k++) data[at + k] = values[i + k];
    }
  }
  return new DataTexture(data, size, size, RGBAFormat, HalfFloatType);
}

// The texture of a scene's environment; sky: { top, rim, low }, colours in linear light.
export function reflectionsOf(sky, up) {
  const level = (lod) => {
    const values = table(sky, 1 - Math.sqrt(1 - Math.min(1, lod / (LEVELS - 1))));
    return FACES.map((direction) => face(direction, SIZE >> lod, up, values));
  };
  const texture = new CubeTexture(level(0));
  texture.mipmaps = [];
  for (let lod = 1; lod <= LEVELS; lod++) texture.mipmaps.push({ image: level(lod) });       // three.js takes the last to be one beyond
  Object.assign(texture, { format: RGBAFormat, type: HalfFloatType, magFilter: LinearFilter, minFilter: LinearMipmapLinearFilter,
    generateMipmaps: false, colorSpace: LinearSRGBColorSpace, isPMREMTexture: true, needsUpdate: true });
  return texture;
}
