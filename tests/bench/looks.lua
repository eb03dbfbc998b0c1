-- tests/bench/looks.lua: one scene for two renderers, `make bench SCENE=looks`: ours draws it here, and what there is to draw goes to
-- stdout, a line a body, for MuJoCo's (looks.c).
local digbox = require "digbox"
local world = digbox.world { seed = 3 }

local paints = { { 0.75, 0.10, 0.08 }, { 0.08, 0.42, 0.75 }, { 0.10, 0.50, 0.22 }, { 0.85, 0.62, 0.08 }, { 0.08, 0.52, 0.56 },
  { 0.14, 0.14, 0.17 } }
local brown, red, grey = { 0.58, 0.38, 0.19 }, { 0.62, 0.28, 0.18 }, { 0.60, 0.60, 0.62 }
-- Colours above are as seen on a screen, as MuJoCo takes them; ours are amounts of light.
local function light(c) return { c[1] ^ 2.2, c[2] ^ 2.2, c[3] ^ 2.2 } end
local list = {}

local function add(kind, body, size, colour, shine)
  list[#list + 1] = { kind = kind, body = body, size = size, colour = colour, shine = shine }
end

local function place(i, n)      -- in rings above the floor
  local turn, ring = i * 2.399963, 0.28 * math.sqrt(i % n)
  return { ring * math.cos(turn), 0.35 + 0.24 * (i // n), ring * math.sin(turn) }
end

digbox.material("polished", { like = "tile", roughness = 0.05 })
world:floor { material = "polished" }
for i = 0, 59 do
  local a, b = 0.15 + 0.010 * (i % 5), 0.12 + 0.012 * (i % 7)
  local at, paint = place(i, 12), paints[(i // 6 + i) % 6 + 1]
  local spin = digbox.quat { axis = { 1, i % 3, 0.5 }, angle = 0.7 * i }
  local kind = i % 6
  if kind < 3 then
    local size = { 2 * a, 2 * b, kind == 1 and 2 * a or 2 * b }
    local box = world:box { size = size, at = at, rotation = spin, material = ({ [0] = "oak", "brick", "plastic" })[kind],
      colour = kind == 2 and light(paint) or nil }
    add("box", box, { size[1] / 2, size[2] / 2, size[3] / 2 }, kind == 0 and brown or kind == 1 and red or paint, kind == 2 and 0.5 or 0.1)
  elseif kind == 3 then
    add("sphere", world:ball { radius = b, at = at, material = "steel" }, { b, 0, 0 }, grey, 0.9)
  elseif kind == 4 then
    local body = world:capsule { radius = 0.6 * b, length = 2 * a, at = at, rotation = spin, material = "plastic", colour = light(paint) }
    add("capsule", body, { 0.6 * b, a, 0 }, paint, 0.5)
  else
    add("cylinder", world:cylinder { radius = b, height = 1.6 * a, at = at, rotation = spin, material = "rubber", colour = light(paint) },
      { b, 0.8 * a, 0 }, paint, 0.2)
  end
end

local at, target = digbox.vec(2.6, 1.7, 2.9), digbox.vec(0.05, 0.22, 0)
local camera = world:camera { at = at, look_at = target, fov = "40 deg" }
world:sun { from = { 3, 6, 2 } }
world:run "2.5 s"
world:render { camera = camera, to = "digbox.png" }

print(("camera %.9g %.9g %.9g  %.9g %.9g %.9g  40"):format(at.x, at.y, at.z, target.x, target.y, target.z))
print "sun 3 6 2"
for _, one in ipairs(list) do
  local p, q = one.body.position, one.body.rotation
  print(("%s %.6g %.6g %.6g  %.9g %.9g %.9g  %.9g %.9g %.9g %.9g  %.3g %.3g %.3g %.3g"):format(one.kind, one.size[1], one.size[2],
    one.size[3], p.x, p.y, p.z, q.w, q.x, q.y, q.z, one.colour[1], one.colour[2],
    one.colour[3], one.shine))
end
