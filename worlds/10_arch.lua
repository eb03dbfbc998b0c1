-- 10_arch.lua: two arches of loose stones, nothing but friction between them.
--   Look at:   the thick one stands; the thin one opens at five joints and comes down.
--   Law:       a half-circle arch stands under its own weight when its thickness is over 0.1075 of its mean radius, whatever its
--              size and density (Milankovitch 1907). Each foot of the one that stands carries half of its weight.
--   Expected:  0.15 stands, 0.08 falls.
--   digbox run worlds/10_arch.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local R, depth, n = 1, 0.4, 12

local world = digbox.world {}
local floor = world:floor { material = "stone", friction = 1 }
local function arch(name, thickness, z)     -- n wedges from angle 0 to pi in the plane x, y
  local stones, inner, outer = {}, R - thickness / 2, R + thickness / 2
  for i = 1, n do
    local from, to, points = math.pi * (i - 1) / n, math.pi * i / n, {}
    local mid = digbox.vec(R * math.cos((from + to) / 2), R * math.sin((from + to) / 2), z)
    for _, angle in ipairs { from, to } do
      for _, r in ipairs { inner, outer } do
        for side = -1, 1, 2 do
          points[#points + 1] = digbox.vec(r * math.cos(angle), r * math.sin(angle), z + side * depth / 2) - mid
        end
      end
    end
    stones[i] = world:hull { name = name .. " " .. i, points = points, at = mid, material = "stone", friction = 1, restitution = 0,
                             colour = i % 2 == 0 and { 0.42, 0.36, 0.28 } or nil }
  end
  return stones
end
local thick, thin = arch("thick", 0.15 * R, -0.4), arch("thin", 0.08 * R, 0.4)
local eye = world:camera { at = { 1.6, 1.5, 4 }, look_at = { 0, 0.45, 0 }, fov = "38 deg" }
if opt.film then world:record { camera = eye, to = "10_arch-%05d.png", fps = 30 } end

local crown = { thick = thick[n // 2].position.y, thin = thin[n // 2].position.y }
world:run "4 s"
local weight, foot = 0, 0
for _, stone in ipairs(thick) do weight = weight + stone.mass * 9.81 end
for _, link in ipairs(thick[1]:links()) do
  if link.b == floor then foot = foot - link.effort.y elseif link.a == floor then foot = foot + link.effort.y end
end
local law = {
  { "thick: crown sank, m", crown.thick - thick[n // 2].position.y, 0, 0.01 },
  { "thick: foot carries, N", foot, weight / 2, 0.02 * weight },
  { "thin: crown fell, m", crown.thin - thin[n // 2].position.y, R, 0.25 * R },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
