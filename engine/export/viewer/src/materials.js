// materials.js - physically based materials with the patterns of engine/render/shaders.c (wood, brick, tiles, stripes, checks),
// computed in the shader from the place on the body: no pictures, nothing to load.
import { Color, DoubleSide, FrontSide, MeshStandardMaterial, Vector3, Vector4 } from "three";

const NUMBERS = { plain: 0, wood: 1, brick: 2, tile: 3, stripe: 4, check: 5 };

const COMMON = /* glsl */ `
varying vec3 digPlace;
uniform vec3 digHalf;
uniform vec4 digLook;       // cells a metre, axis or band kind, width of a band, seed
float digHash(ivec2 c) {
  uint h = uint(c.x) * 0x27d4eb2du ^ uint(c.y) * 0x9e3779b1u;
  h = (h ^ (h >> 15)) * 0x85ebca6bu;
  return float((h ^ (h >> 13)) & 0xffffu) * (1.0 / 65535.0);
}
float digNoise(vec2 p) {
  vec2 i = floor(p), f = p - i;
  f = f * f * (3.0 - 2.0 * f);
  ivec2 c = ivec2(i);
  return mix(mix(digHash(c), digHash(c + ivec2(1, 0)), f.x), mix(digHash(c + ivec2(0, 1)), digHash(c + ivec2(1, 1)), f.x), f.y);
}
vec2 digFace(vec3 p) {
  vec3 a = abs(p / digHalf), w = step(a.yzx, a) * step(a.zxy, a);
  return w.x * p.zy + w.y * p.xz + w.z * p.xy;
}
float digJoints(vec2 uv, vec2 w, vec2 width) {
  vec2 d = 0.5 - abs(fract(uv) - 0.5), l = clamp((width - d) / w + 0.5, 0.0, 1.0);
  l = mix(l, 2.0 * width, clamp(w * 2.0 - 0.4, 0.0, 1.0));
  return l.x + l.y - l.x * l.y;
}
vec3 digColour(vec3 c) {
  vec3 p = digPlace;
#if DIG_PLANE
  vec2 uv = p.xz * digLook.x, w = fwidth(uv) + 1e-5;
  float fine = clamp(1.5 - 2.0 * max(w.x, w.y), 0.0, 1.0);
#if DIG_PATTERN == 5
  vec2 q = abs(fract(uv * 0.5) - 0.5) - 0.25, s = clamp(q / (0.5 * w), -0.5, 0.5);
  return c * (1.0 - 0.42 * (0.5 - 2.0 * s.x * s.y * fine));
#else
  return c * (1.0 + 0.10 * fine * (digHash(ivec2(floor(uv))) - 0.5)) * (1.0 - 0.45 * digJoints(uv, w, vec2(0.011)));
#endif
#elif DIG_PATTERN == 1
  vec3 g = (digLook.y < 0.5 ? p : digLook.y < 1.5 ? p.yzx : p.zxy) * digLook.x;
  float slow = digNoise(vec2(g.x * 0.5 + digLook.w, g.y * 1.1 + g.z * 1.6 + digLook.w * 0.7));
  float fibre = digNoise(vec2(g.x * 1.6 + digLook.w, (g.y * 1.3 + g.z * 1.9) * 14.0));
  float r = length(g.yz * 0.5 + vec2(0.31, 0.47) + (slow - 0.5) * 0.16) * 9.0 + slow * 0.8, w = fwidth(r), ring = fract(r);
  ring = mix(ring * ring * (1.0 - ring) * 5.0, 0.42, clamp(w * 2.0 - 0.4, 0.0, 1.0));
  return mix(c * 1.22, c * vec3(0.50, 0.42, 0.36), clamp(ring * 0.55 + fibre * fibre * 0.75 - 0.12, 0.0, 1.0));
#elif DIG_PATTERN == 2
  vec2 uv = digFace(p) * digLook.x * vec2(1.0, 2.4);
  uv.x += 0.5 * mod(floor(uv.y), 2.0);
  float tint = digHash(ivec2(floor(uv)) + ivec2(int(digLook.w * 64.0), 0));
  vec3 brick = c * (0.72 + 0.56 * tint) + vec3(0.03, 0.012, 0.004) * (digNoise(uv * 9.0) - 0.5);
  return mix(brick, vec3(0.50, 0.47, 0.43), digJoints(uv, fwidth(uv) + 1e-5, vec2(0.035, 0.085)));
#elif DIG_PATTERN == 3
  vec2 uv = digFace(p) * (0.95 * digLook.x);
  float tint = digHash(ivec2(floor(uv)) + ivec2(int(digLook.w * 64.0), 0));
  return c * (0.90 + 0.2 * tint) * (1.0 - 0.5 * digJoints(uv, fwidth(uv) + 1e-5, vec2(0.030)));
#elif DIG_PATTERN == 4
  float s = abs(p.y * digLook.x), w = fwidth(s) + 1e-5;
  float band = clamp((digLook.z - abs(s - floor(s + 0.5))) / w + 0.5, 0.0, 1.0);
  return mix(c, vec3(0.80, 0.79, 0.77), digLook.y > 0.5 ? band : 1.0 - band);
#elif DIG_PATTERN == 5
  vec3 q = p * (0.99 * digLook.x) + 0.25, w = fwidth(q) + 1e-4, s = clamp((0.25 - abs(fract(q) - 0.5)) / w, -0.5, 0.5);
  return mix(c, vec3(0.80, 0.79, 0.77), 0.5 - 4.0 * s.x * s.y * s.z);
#else
  return c;
#endif
}
`;

// Length of one repeat on a solid with these half extents: as pattern_cell in engine/render/batch.c.
function cellOf(pattern, form, half) {
  const small = 2 * Math.min(...half), large = 2 * Math.max(...half);
  if (pattern === "wood") return Math.max(small, 0.25 * large);
  if (pattern === "brick") return large / Math.ceil(Math.min(40, Math.max(1, large / (1.6 * small)))) / 1.5;
  if (pattern === "tile") return small / 2;
  if (pattern === "stripe") return form === "box" ? half[1] : 2.6 * half[1];
  if (pattern === "check") return form === "box" ? small / 2 : 2 * large;
  return 1;
}

export function bodyMaterial(shape, form, half, seed, plane) {
  const pattern = plane ? (shape.pattern === "check" ? "check" : "tile") : shape.pattern;
  const material = new MeshStandardMaterial({
    color: new Color().setRGB(...shape.colour), roughness: Math.min(1, Math.max(0.08, shape.roughness)), metalness: shape.metallic,
    transparent: shape.opacity < 1, opacity: shape.opacity, depthWrite: shape.opacity >= 1,
    side: form === "mesh" ? DoubleSide : FrontSide,
  });
  const axis = half.indexOf(Math.max(...half));
  const band = pattern === "stripe" ? (form === "sphere" || form === "box" ? 1 : 0) : axis;
  const width = form === "sphere" ? 0.125 : form === "capsule" || form === "cylinder" ? 0.16 : 0.25;
  const own = {
    digHalf: { value: new Vector3(...half) },
    digLook: { value: new Vector4(1 / (plane || Math.max(1e-9, cellOf(pattern, form, half))), band, width, seed) },
  };
  material.defines = { DIG_PATTERN: NUMBERS[pattern] ?? 0, DIG_PLANE: plane ? 1 : 0 };
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, own);
    shader.vertexShader = `varying vec3 digPlace;\n${shader.vertexShader.replace("#include <begin_vertex>", "#include <begin_vertex>\ndigPlace = position;")}`;
    shader.fragmentShader = COMMON + shader.fragmentShader.replace("#include <color_fragment>",
      "#include <color_fragment>\ndiffuseColor.rgb = digColour(diffuseColor.rgb);");
  };
  material.customProgramCacheKey = () => `digbox ${pattern} ${plane ? 1 : 0}`;
  material.userData.plain = material.color.clone();
  return material;
}
