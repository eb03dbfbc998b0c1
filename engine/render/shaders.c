/* render/shaders.c - the GLSL of every program.
 *
 * Prices on llvmpipe (a full 1280x720 screen): multiply-add 0.06 ms, inverse square root 0.5, bilinear fetch 3,
 * hardware-compared shadow tap 3.3, one octave of hash noise 1.4. An `if` never skips anything; hence the #ifs.
 *
 * Solids and planes look as in block_look.h and block_light.h, which do the same on the CPU: change both.
 *
 * The alpha of a colour picture says what a pixel shows, for render/smooth.c: 0..239 a side of a body, 240..253 a plane,
 * 255 the sky. Where render/shade.h does the shading, 254 marks what it is still to shade.
 */
#include "render/shaders.h"

/* ---- shared ----------------------------------------------------------- */

static const char frame_block[] =
    "layout(std140) uniform Frame {\n"
    "    mat4 to_clip, to_sun;\n"
    "    vec4 eye, forward, ray[3], sun, sun_colour, zenith, horizon, ground, sky_top, sky_rim, sky_low, top, shade, world[3];\n"
    "    vec4 lamp_at[4], lamp_colour[4], screen;\n"
    "};\n"
    /* one curve for tone and for the display's gamma: white is reached softly, and what is dark stands out */
    "vec3 shown(vec3 light) {\n"
    "    vec3 y = light * 1.03 / (light + 0.195);\n"
    "    return y * (1.0 + 0.6 * (1.0 - y) * (y - 0.62));\n"
    "}\n";

/* Instance attributes and the way from a unit solid into the scene. */
static const char solid_inputs[] =
    "layout(location = 0) in vec3 shape;\n"
    "layout(location = 1) in vec4 shape_normal;\n"         /* w: share of the shift */
    "layout(location = 2) in vec4 place;\n"                /* relative to the eye; w: seed */
    "layout(location = 3) in vec4 turning;\n"
    "layout(location = 4) in vec4 size;\n"                 /* w: shift along y */
    "layout(location = 5) in vec4 colour;\n"               /* w: roughness */
    "layout(location = 6) in vec4 look;\n"                 /* metallic (below 0: it shines), bevel, 1 / cell, grain axis */
    "layout(location = 7) in vec4 half_size;\n"            /* of the solid; planes: offset of the tiles */
    "layout(location = 8) in uvec2 number;\n"
    "layout(location = 9) in float clear;\n"             /* 1 - opacity */
    "vec3 turn(vec4 q, vec3 v) { vec3 t = 2.0 * cross(q.xyz, v); return v + q.w * t + cross(q.xyz, t); }\n"
    "vec3 own() { return shape * size.xyz + vec3(0.0, shape_normal.w * size.w, 0.0); }\n";

/* ---- surfaces --------------------------------------------------------- */

/* Share of the sky that is seen from a point (on the maps over the floor; height) with that normal. */
static const char sky_share[] =
    "uniform sampler2D height_map;\n"
    "float sky_seen(vec3 at, vec2 n) {\n"
    "    vec2 h = clamp(textureLod(height_map, at.xy + n * top.y, 0.0).xy - at.z, 0.0, shade.w);\n"
    "    return 1.0 / (1.0 + shade.x * h.x + shade.y * h.y);\n"
    "}\n"
    /* what the floor leaves of it near by, for what does not face upwards */
    "float above_floor(float z, float up) {\n"
    "    float low = clamp(1.0 - (z - shade.z) * ground.w, 0.0, 1.0);\n"
    "    return 1.0 - low * low * (0.2 - 0.2 * up);\n"
    "}\n";

static const char surface_vertex[] =
    "out vec3 v_rel, v_p, v_n, v_sun, v_top;\n"
    "out float v_sky;\n"
    "flat out vec4 f_colour, f_look, f_half;\n"
    "flat out vec3 f_x, f_y, f_z, f_direct, f_sky;\n"
    "flat out float f_seed, f_key, f_clear;\n"
    "flat out vec2 f_grain;\n"
    "void main() {\n"
    "    vec3 p = own();\n"
    "    v_p = p;\n"
    "    v_rel = turn(turning, p) + place.xyz;\n"
    "    v_n = turn(turning, shape_normal.xyz / max(size.xyz, 1e-12));\n"
    "    f_x = turn(turning, vec3(1, 0, 0));\n"
    "    f_y = turn(turning, vec3(0, 1, 0));\n"
    "    f_z = turn(turning, vec3(0, 0, 1));\n"
    "    f_direct = max(dot(f_y, sun.xyz), 0.0) * sun_colour.rgb;\n"
    "    f_sky = mix(ground.rgb, zenith.rgb, f_y.z * 0.5 + 0.5);\n"
    "    v_sun = (to_sun * vec4(v_rel, 1.0)).xyz - vec3(0.0, 0.0, 0.5 + sun.w);\n"
    "    vec3 w = v_rel + eye.xyz;\n"
    "    v_top = vec3(w.xy * top.x + top.zw, w.z);\n"
    "#if CORNER_SKY && FORM == 2\n"
    "    v_sky = sky_seen(v_top, turn(turning, shape_normal.xyz).xy);\n"
    "#elif CORNER_SKY\n"
    "    v_sky = sky_seen(v_top, normalize(v_n).xy);\n"
    "#endif\n"
    "    f_colour = colour;\n"
    "    f_look = look;\n"
    "    f_half = half_size;\n"
    "    f_seed = place.w;\n"
    "    f_clear = clear;\n"
    "    f_key = (float((number.y * 157u) % 240u) + 0.25) * (1.0 / 240.0);\n"
    "    f_grain = vec2(look.w == 1.0, look.w == 2.0);\n"
    "    gl_Position = to_clip * vec4(v_rel, 1.0);\n"
    "}\n";

static const char surface_inputs[] =
    "in vec3 v_rel, v_p, v_n, v_sun, v_top;\n"
    "in float v_sky;\n"
    "flat in vec4 f_colour, f_look, f_half;\n"
    "flat in vec3 f_x, f_y, f_z, f_direct, f_sky;\n"
    "flat in float f_seed, f_key, f_clear;\n"
    "flat in vec2 f_grain;\n"
    "uniform sampler2D sun_map, floor_map, mirror_map;\n"
    "#if CLEAR\n"
    "layout(location = 0, index = 0) out vec4 pixel;\n"
    "layout(location = 0, index = 1) out vec4 key_factor;\n"
    "#else\n"
    "layout(location = 0) out vec4 pixel;\n"
    "#endif\n";

/* Normal in scene axes. The edges of a box look rounded: outside the box shrunk by the bevel, the normal points away
 * from the nearest point of that smaller box, as on a rounded one. A cylinder likewise, in (radius, height). */
static const char surface_normal[] =
    /* also: which side of the solid this is, for the smoothing of edges */
    "float side = 0.0;\n"
    "vec3 normal() {\n"
    "#if FORM == 2\n"
    "    vec3 t = max(abs(v_p) - f_half.xyz + f_look.y, 0.0) + 1e-4 * f_look.y;\n"
    "    vec3 n = t * sign(v_p);\n"
    "    side = 1.0 + dot(step(t.yzx, t) * step(t.zxy, t), vec3(0.0, 1.0, 2.0));\n"
    "    return normalize(f_x * n.x + f_y * n.y + f_z * n.z);\n"
    "#elif FORM == 3\n"
    "    float d = max(length(v_p.xz), 1e-9);\n"
    "    vec2 t = max(vec2(d, abs(v_p.y)) - f_half.xy + f_look.y, 0.0) + 1e-4 * f_look.y;\n"
    "    vec3 n = vec3(v_p.xz * (t.x / d), sign(v_p.y) * t.y).xzy;\n"
    "    side = step(t.x, t.y);\n"
    "    return normalize(f_x * n.x + f_y * n.y + f_z * n.z);\n"
    "#elif FORM == 4\n"
    "    side = floor(fract(dot(v_n, vec3(1.31, 2.17, 3.73))) * 8.0);\n"
    "    return normalize(dot(v_n, v_rel) > 0.0 ? -v_n : v_n);\n"
    "#elif FORM == 5\n"
    "    side = floor(fract(dot(normalize(v_n), vec3(1.31, 2.17, 3.73))) * 8.0);\n"
    "    return normalize(v_n);\n"
    "#else\n"
    "    return normalize(v_n);\n"
    "#endif\n"
    "}\n";

static const char noise_functions[] =
    "float hash(ivec2 c) {\n"
    "    uint h = uint(c.x) * 0x27d4eb2du ^ uint(c.y) * 0x9e3779b1u;\n"
    "    h = (h ^ (h >> 15)) * 0x85ebca6bu;\n"
    "    return float((h ^ (h >> 13)) & 0xffffu) * (1.0 / 65535.0);\n"
    "}\n"
    "float noise(vec2 p) {\n"
    "    vec2 i = floor(p), f = p - i;\n"
    "    f = f * f * (3.0 - 2.0 * f);\n"
    "    ivec2 c = ivec2(i);\n"
    "    return mix(mix(hash(c), hash(c + ivec2(1, 0)), f.x), mix(hash(c + ivec2(0, 1)), hash(c + ivec2(1, 1)), f.x), f.y);\n"
    "}\n"
    /* coordinates on the face of a solid that a point lies on */
    "vec2 face(vec3 p) {\n"
    "    vec3 a = abs(p / f_half.xyz);\n"
    "    vec3 w = step(a.yzx, a) * step(a.zxy, a);\n"
    "    return w.x * p.zy + w.y * p.xz + w.z * p.xy;\n"
    "}\n"
    /* 1 on a joint of the given half width round whole numbers, 0 off it; turns into the mean where pixels are coarse */
    "float joints(vec2 uv, vec2 w, vec2 width) {\n"
    "    vec2 d = 0.5 - abs(fract(uv) - 0.5);\n"
    "    vec2 l = clamp((width - d) / w + 0.5, 0.0, 1.0), mean = 2.0 * width;\n"
    "    l = mix(l, mean, clamp(w * 2.0 - 0.4, 0.0, 1.0));\n"
    "    return l.x + l.y - l.x * l.y;\n"
    "}\n";

static const char surface_patterns[] =
    "vec3 albedo() {\n"
    "    vec3 c = f_colour.rgb;\n"
    "#if PLANE\n"
    "    vec2 uv = v_p.xz * f_look.z + f_half.xy, step_uv = fwidth(uv) + 1e-5;\n"
    "    float fine = clamp(1.5 - 2.0 * max(step_uv.x, step_uv.y), 0.0, 1.0);\n"
    "#if PATTERN == 5\n"
    "    vec2 q = abs(fract(uv * 0.5) - 0.5) - 0.25, s = clamp(q / (0.5 * step_uv), -0.5, 0.5);\n"
    "    return c * (1.0 - 0.42 * (0.5 - 2.0 * s.x * s.y * fine));\n"
    "#elif PATTERN == 4\n"
    "    float q = abs(fract(uv.x * 0.5) - 0.5) - 0.25, s = clamp(q / (0.5 * step_uv.x), -0.5, 0.5);\n"
    "    return c * (1.0 - 0.40 * (0.5 - s * fine));\n"
    "#else\n"
    "    ivec2 cell = ivec2(floor(uv));\n"
    "    float tint = (hash(cell) - 0.5) * 0.10;\n"
    "    return c * (1.0 + tint * fine) * (1.0 - 0.45 * joints(uv, step_uv, vec2(0.011)));\n"
    "#endif\n"
    "#elif PATTERN == 1\n"
    "    vec3 g = mix(mix(v_p, v_p.yzx, f_grain.x), v_p.zxy, f_grain.y) * f_look.z;\n"
    "    float slow = noise(vec2(g.x * 0.5 + f_seed, g.y * 1.1 + g.z * 1.6 + f_seed * 0.7));\n"
    "    float fibre = noise(vec2(g.x * 1.6 + f_seed, (g.y * 1.3 + g.z * 1.9) * 14.0));\n"
    "    vec2 q = g.yz * 0.5 + vec2(0.31, 0.47) + (slow - 0.5) * 0.16;\n"
    "    float r = length(q) * 9.0 + slow * 0.8, w = fwidth(r);\n"
    "    float ring = fract(r);\n"
    "    ring = ring * ring * (1.0 - ring) * 5.0;\n"
    "    ring = mix(ring, 0.42, clamp(w * 2.0 - 0.4, 0.0, 1.0));\n"
    "    return mix(c * 1.22, c * vec3(0.50, 0.42, 0.36), clamp(ring * 0.55 + fibre * fibre * 0.75 - 0.12, 0.0, 1.0));\n"
    "#elif PATTERN == 2\n"
    "    vec2 uv = face(v_p) * f_look.z * vec2(1.0, 2.4);\n"
    "    uv.x += 0.5 * mod(floor(uv.y), 2.0);\n"
    "    float tint = hash(ivec2(floor(uv)) + ivec2(int(f_seed * 64.0), 0));\n"
    "    float joint = joints(uv, fwidth(uv) + 1e-5, vec2(0.035, 0.085));\n"
    "    vec3 brick = c * (0.72 + 0.56 * tint) + vec3(0.03, 0.012, 0.004) * (noise(uv * 9.0) - 0.5);\n"
    "    return mix(brick, vec3(0.50, 0.47, 0.43), joint);\n"
    "#elif PATTERN == 3\n"
    "    vec2 uv = face(v_p) * (0.95 * f_look.z);\n"        /* ends just short of a joint on the edge */
    "    float tint = hash(ivec2(floor(uv)) + ivec2(int(f_seed * 64.0), 0));\n"
    "    return c * (0.90 + 0.2 * tint) * (1.0 - 0.5 * joints(uv, fwidth(uv) + 1e-5, vec2(0.030)));\n"
    "#elif PATTERN == 4\n"
    "    float s = abs(v_p.y * f_look.z), w = fwidth(s) + 1e-5;\n"
    "    float band = clamp((f_half.w - abs(s - floor(s + 0.5))) / w + 0.5, 0.0, 1.0);\n"
    "    return mix(c, vec3(0.80, 0.79, 0.77), f_look.w > 0.5 ? band : 1.0 - band);\n"
    "#elif PATTERN == 5\n"
    "    vec3 q = v_p * (0.99 * f_look.z) + 0.25, w = fwidth(q) + 1e-4;\n"
    "    vec3 s = clamp((0.25 - abs(fract(q) - 0.5)) / w, -0.5, 0.5);\n"
    "    return mix(c, vec3(0.80, 0.79, 0.77), 0.5 - 4.0 * s.x * s.y * s.z);\n"
    "#else\n"
    "    return c;\n"
    "#endif\n"
    "}\n";

/* x: share of the sun that arrives; y: share of the sky that is seen. The floor's map brings a marbling along. */
static const char surface_light[] =
    "vec2 arriving(vec3 n, inout vec3 c) {\n"
    "#if OPEN\n"
    "    c *= 0.90 + 0.20 * (128.0 / 255.0);\n"
    "    return vec2(1.0);\n"
    "#elif FLOOR\n"
    "    vec3 m = texture(floor_map, v_top.xy).xyz;\n"
    "    c *= 0.90 + 0.20 * m.z;\n"
    "    return m.xy;\n"
    "#else\n"
    "    float lit = 1.0;\n"
    "#if SHADOWS\n"
    "    vec2 m = texture(sun_map, v_sun.xy).xy;\n"
    "    float behind = max(min(v_sun.z, 0.5) - m.x, 0.0), spread = max(m.y - m.x * m.x, sun_colour.w);\n"
    "    lit = clamp(1.25 * spread / (spread + behind * behind) - 0.25, 0.0, 1.0);\n"
    "#endif\n"
    "#if CORNER_SKY\n"
    "    return vec2(lit, v_sky * above_floor(v_top.z, n.z));\n"
    "#else\n"
    "    return vec2(lit, sky_seen(v_top, n.xy) * above_floor(v_top.z, n.z));\n"
    "#endif\n"
    "#endif\n"
    "}\n"
    /* GGX with its masking folded in (after Karis 2013), Schlick's Fresnel, hemisphere light, a sky for mirrors */
    "vec3 gloss(vec3 n, vec3 v, vec3 l, vec3 f0, float rough) {\n"
    "    vec3 h = normalize(l + v);\n"
    "    float nh = max(dot(n, h), 0.0), lh = dot(l, h), a2 = rough * rough * rough * rough;\n"
    "    float d = nh * nh * (a2 - 1.0) + 1.00001;\n"
    "    return f0 * (a2 / (d * d * max(0.1, lh * lh) * (4.0 * rough + 2.0)));\n"
    "}\n";

static const char surface_main[] =
    "void main() {\n"
    "#if PLANE\n"
    "    vec3 n = f_y;\n"
    "#else\n"
    "    vec3 n = normal();\n"
    "#endif\n"
    "    vec3 v = -normalize(v_rel), c = albedo();\n"
    "    vec2 come = arriving(n, c);\n"
    "    float rough = f_colour.a, metal = max(f_look.x, 0.0);\n"
    "#if PLANE\n"
    "    vec3 lit = c * (come.x * f_direct + come.y * f_sky);\n"
    "#else\n"
    "    float nu = n.z, nv = max(dot(n, v), 0.0), nl = max(dot(n, sun.xyz), 0.0);\n"
    "    vec3 f0 = mix(vec3(0.04), c, metal), diffuse = c * (1.0 - metal);\n"
    "    float f = 1.0 - nv, f2 = f * f;\n"
    "    float smoothness = 1.0 - rough;\n"
    "    vec3 fresnel = f0 * (1.0 - 0.6 * rough) + (1.0 - f0) * (f2 * f2 * f * smoothness * smoothness);\n"
    "    float up = 2.0 * nv * nu - v.z;\n"
    "    vec3 mirror = mix(mix(ground.rgb * 0.8, horizon.rgb, clamp(up * 0.9 + 0.62, 0.0, 1.0)), zenith.rgb, clamp(up, 0.0, 1.0));\n"
    "    vec3 lit = (diffuse + gloss(n, v, sun.xyz, f0, rough)) * (nl * come.x) * sun_colour.rgb +\n"
    "               (diffuse * mix(ground.rgb, zenith.rgb, nu * 0.5 + 0.5) + fresnel * mirror) * come.y;\n"
    "#endif\n"
    "#if LAMPS\n"
    "    for (int i = 0; i < LAMPS; i++) {\n"
    "        vec3 to = lamp_at[i].xyz - v_rel;\n"
    "        float near = 1.0 / max(dot(to, to), 1e-6);\n"
    "        vec3 l = to * sqrt(near), e = lamp_colour[i].rgb * (near * max(dot(n, l), 0.0));\n"
    "        lit += (c * (1.0 - metal) + gloss(n, v, l, mix(vec3(0.04), c, metal), rough)) * e;\n"
    "    }\n"
    "#endif\n"
    "#if PLANE\n"        /* v_p is centred under the eye: less to interpolate */
    "    float far = 1.0 - min(dot(v_p.xz, v_p.xz) * forward.w, 1.0);\n"
    "#else\n"
    "    float far = 1.0 - min(dot(v_rel, v_rel) * forward.w, 1.0);\n"
    "#endif\n"
    "    lit += c * max(-f_look.x, 0.0);\n"
    "    lit = mix(sky_rim.rgb, lit, far * far);\n"
    "#if PLANE\n"
    "    float key = (240.0 + floor(f_key * 14.0)) * (1.0 / 255.0);\n"
    "#else\n"
    "    float key = fract(f_key + side * (37.0 / 240.0)) * (240.0 / 255.0);\n"
    "#endif\n"
    "#if CLEAR\n"        /* what glances off is not let through */
    "    float stops = 1.0 - f_clear, steep = 1.0 - max(dot(n, v), 0.0), steep2 = steep * steep;\n"
    "    stops += f_clear * (1.0 - rough) * (0.02 + 0.98 * steep2 * steep2 * steep);\n"
    /* what is added in levels of eight bits, twice, would show their steps */
    "    float grain = fract(52.9829 * fract(dot(gl_FragCoord.xy, vec2(0.06711, 0.00584)))) - 0.5;\n"
    "    pixel = vec4(shown(lit) * stops + grain * (1.0 / 255.0), stops);\n"
    "    key_factor = vec4(0.95 - 0.3 * fract(key * 7.0));\n"
    "#else\n"
    "    pixel = vec4(shown(lit), key);\n"
    "#endif\n"
    "#if MIRROR\n"
    "    float across = 1.0 - abs(dot(n, v)), across2 = across * across;\n"
    "    vec3 f1 = mix(vec3(0.08), f_colour.rgb, f_look.w), share = (f1 + (1.0 - f1) * (across2 * across2 * across)) * f_look.y;\n"
    "    pixel.rgb = mix(pixel.rgb, texture(mirror_map, gl_FragCoord.xy * screen.xy * 0.5).rgb, share);\n"
    "#endif\n"
    "}\n";

/* ---- sky -------------------------------------------------------------- */

static const char sky_vertex[] =
    "out vec3 v_ray;\n"
    "void main() {\n"
    "    vec2 p = vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID & 2) == 0 ? screen.z : 1.0);\n"
    "    v_ray = ray[0].xyz * p.x + ray[1].xyz * p.y + ray[2].xyz;\n"
    "    gl_Position = vec4(p, 1.0, 1.0);\n"
    "}\n";

static const char sky_fragment[] =
    "in vec3 v_ray;\n"
    "layout(location = 0) out vec4 pixel;\n"
    "void main() {\n"
    "    vec3 d = normalize(v_ray);\n"
    "    float high = 1.0 - clamp(d.z * 1.15, 0.0, 1.0), low = clamp(-d.z * 1.6 - 0.12, 0.0, 1.0), s = max(dot(d, sun.xyz), 0.0);\n"
    "    s = s * s * s;\n"
    "    vec3 c = mix(mix(sky_top.rgb, sky_rim.rgb, high * high * high * high), sky_low.rgb, low) + sun_colour.rgb * (s * s * sky_top.w);\n"
    "    pixel = vec4(shown(c), 1.0);\n"
    "}\n";

/* ---- numbers: what render/shade.h goes on from ------------------------- */

static const char number_vertex[] =
    "flat out vec3 f_number;\n"
    "void main() {\n"
    "    f_number = vec3(uvec3(number.y, number.y >> 8, number.y >> 16) & 255u) * (1.0 / 255.0);\n"
    "    gl_Position = to_clip * vec4(turn(turning, own()) + place.xyz, 1.0);\n"
    "}\n";

static const char number_fragment[] =
    "flat in vec3 f_number;\n"
    "layout(location = 0) out vec4 pixel;\n"
    "void main() { pixel = vec4(f_number, 254.0 / 255.0); }\n";

/* ---- depth, id, normal ------------------------------------------------ */

static const char plain_vertex[] =
    "out vec3 v_rel, v_p, v_n;\n"
    "flat out vec4 f_half, f_ball, f_look;\n"
    "flat out vec3 f_x, f_y, f_z;\n"
    "flat out uint f_number;\n"
    "void main() {\n"
    "    v_p = own();\n"
    "    v_rel = turn(turning, v_p) + place.xyz;\n"
    "    v_n = turn(turning, shape_normal.xyz / max(size.xyz, 1e-12));\n"
    "    f_x = turn(turning, vec3(1, 0, 0));\n"
    "    f_y = turn(turning, vec3(0, 1, 0));\n"
    "    f_z = turn(turning, vec3(0, 0, 1));\n"
    "    f_half = half_size;\n"
    "    f_ball = vec4(place.xyz, size.x);\n"
    "    f_look = vec4(0.0, 0.002 * min(half_size.x, min(half_size.y, half_size.z)), 0.0, 0.0);\n"     /* all but sharp edges */
    "    f_number = number.x;\n"
    "    gl_Position = to_clip * vec4(v_rel, 1.0);\n"
    "}\n";

static const char plain_inputs[] =
    "in vec3 v_rel, v_p, v_n;\n"
    "flat in vec4 f_half, f_ball, f_look;\n"
    "flat in vec3 f_x, f_y, f_z;\n"
    "flat in uint f_number;\n"
    /* where the ray through this pixel meets the true sphere; its mesh lies a little inside */
    "vec3 point() {\n"
    "#if FORM == 1\n"
    "    vec3 d = normalize(v_rel);\n"
    "    float b = dot(d, f_ball.xyz);\n"
    "    vec3 off = f_ball.xyz - d * b;\n"
    "    return d * (b - sqrt(max(f_ball.w * f_ball.w - dot(off, off), 0.0)));\n"
    "#else\n"
    "    return v_rel;\n"
    "#endif\n"
    "}\n";

static const char depth_main[] =
    "layout(location = 0) out float metres;\n"
    "void main() { metres = dot(point(), forward.xyz) * eye.w; }\n";

static const char id_main[] =
    "layout(location = 0) out uint body;\n"
    "void main() { body = f_number; }\n";

static const char normal_main[] =
    "layout(location = 0) out vec4 pixel;\n"
    "void main() {\n"
    "#if FORM == 1\n"
    "    vec3 n = normalize(point() - f_ball.xyz);\n"
    "#else\n"
    "    vec3 n = normal();\n"
    "#endif\n"
    "    pixel = vec4(vec3(dot(world[0].xyz, n), dot(world[1].xyz, n), dot(world[2].xyz, n)) * 0.5 + 0.5, 1.0);\n"
    "}\n";

/* ---- overlay: strokes and glyphs in pixels ----------------------------- */

static const char stroke_vertex[] =
    "layout(location = 0) in vec4 ends;\n"
    "layout(location = 1) in vec4 widths;\n"       /* radius at either end, width of the dark rim */
    "layout(location = 2) in vec4 colour;\n"
    "out vec2 v_p;\n"
    "flat out vec4 f_ends, f_widths, f_colour;\n"
    "void main() {\n"
    "    vec2 a = ends.xy, b = ends.zw, d = b - a;\n"
    "    float l = length(d), r = max(widths.x, widths.y) + 1.5;\n"
    "    vec2 x = l > 1e-6 ? d / l : vec2(1.0, 0.0), y = vec2(-x.y, x.x);\n"
    "    v_p = ((gl_VertexID & 1) == 0 ? a - x * r : b + x * r) + y * ((gl_VertexID & 2) == 0 ? -r : r);\n"
    "    f_ends = ends;\n"
    "    f_widths = widths;\n"
    "    f_colour = colour;\n"
    "    gl_Position = vec4(v_p.x * screen.x - 1.0, 1.0 - v_p.y * screen.y, 0.0, 1.0);\n"
    "}\n";

static const char stroke_fragment[] =
    "in vec2 v_p;\n"
    "flat in vec4 f_ends, f_widths, f_colour;\n"
    "layout(location = 0) out vec4 pixel;\n"
    "void main() {\n"
    "    vec2 p = v_p - f_ends.xy, d = f_ends.zw - f_ends.xy;\n"
    "    float t = clamp(dot(p, d) / max(dot(d, d), 1e-6), 0.0, 1.0);\n"
    "    float off = length(p - d * t) - mix(f_widths.x, f_widths.y, t);\n"
    "    float core = f_widths.z > 0.0 ? clamp(0.5 - off - f_widths.z, 0.0, 1.0) : 1.0;\n"
    "    pixel = vec4(mix(vec3(0.06), f_colour.rgb, core), f_colour.a * clamp(0.5 - off, 0.0, 1.0));\n"
    "}\n";

static const char glyph_vertex[] =
    "layout(location = 0) in vec4 ends;\n"         /* left, top, right, bottom in pixels */
    "layout(location = 1) in vec4 widths;\n"       /* the same in the font's picture, texels */
    "layout(location = 2) in vec4 colour;\n"
    "out vec2 v_at;\n"
    "flat out vec4 f_colour;\n"
    "void main() {\n"
    "    vec2 p = vec2((gl_VertexID & 1) == 0 ? ends.x : ends.z, (gl_VertexID & 2) == 0 ? ends.y : ends.w);\n"
    "    v_at = vec2((gl_VertexID & 1) == 0 ? widths.x : widths.z, (gl_VertexID & 2) == 0 ? widths.y : widths.w);\n"
    "    f_colour = colour;\n"
    "    gl_Position = vec4(p.x * screen.x - 1.0, 1.0 - p.y * screen.y, 0.0, 1.0);\n"
    "}\n";

static const char glyph_fragment[] =
    "in vec2 v_at;\n"
    "flat in vec4 f_colour;\n"
    "uniform sampler2D font;\n"
    "layout(location = 0) out vec4 pixel;\n"
    "void main() { pixel = vec4(f_colour.rgb, f_colour.a * texelFetch(font, ivec2(floor(v_at)), 0).r); }\n";

const ShaderSource shader_sources[PROGRAM_KIND_COUNT] = {
    [PROGRAM_SURFACE] = {{frame_block, solid_inputs, sky_share, surface_vertex},
                         {frame_block, surface_inputs, surface_normal, noise_functions, surface_patterns, sky_share, surface_light, surface_main}},
    [PROGRAM_SKY] = {{frame_block, sky_vertex}, {frame_block, sky_fragment}},
    [PROGRAM_NUMBER] = {{frame_block, solid_inputs, number_vertex}, {number_fragment}},
    [PROGRAM_DEPTH] = {{frame_block, solid_inputs, plain_vertex}, {frame_block, plain_inputs, depth_main}},
    [PROGRAM_ID] = {{frame_block, solid_inputs, plain_vertex}, {frame_block, plain_inputs, id_main}},
    [PROGRAM_NORMAL] = {{frame_block, solid_inputs, plain_vertex}, {frame_block, plain_inputs, surface_normal, normal_main}},
    [PROGRAM_STROKE] = {{frame_block, stroke_vertex}, {stroke_fragment}},
    [PROGRAM_GLYPH] = {{frame_block, glyph_vertex}, {glyph_fragment}},
};
