-- B24 what no world may take: each must be an error that leaves all other bodies as they were.
local hard = require "hard"
local digbox = require "digbox"

local nan, inf = 0 / 0, math.huge

local function attempts(w, body)
  local list = {}
  local function try(name, fn) list[#list + 1] = { name, fn } end
  for _, bad in ipairs { 0, -1, nan, inf, -inf } do
    try("mass " .. bad, function() w:box { size = 1, mass = bad } end)
    try("size " .. bad, function() w:box { size = { 1, bad, 1 } } end)
    try("radius " .. bad, function() w:ball { radius = bad } end)
    try("step " .. bad, function() digbox.world { step = bad } end)
    try("length " .. bad, function() w:capsule { radius = 0.1, length = bad == 0 and -0.1 or bad } end)
  end
  for _, bad in ipairs { nan, inf, -inf } do
    try("velocity " .. bad, function() w:ball { radius = 1, velocity = { bad, 0, 0 } } end)
    try("spin " .. bad, function() w:ball { radius = 1, spin = { 0, bad, 0 } } end)
    try("at " .. bad, function() w:ball { radius = 1, at = { 0, 0, bad } } end)
    try("push " .. bad, function() body:push { force = { bad, 0, 0 } } end)
    try("twist " .. bad, function() body:twist { torque = { 0, bad, 0 } } end)
    try("hit " .. bad, function() body:hit { impulse = { 0, bad, 0 } } end)
    try("teleport " .. bad, function() body:teleport { at = { bad, 0, 0 } } end)
    try("restitution " .. bad, function() w:ball { radius = 1, restitution = bad } end)
    try("friction " .. bad, function() w:ball { radius = 1, friction = bad } end)
    try("gravity " .. bad, function() w.gravity = { 0, bad, 0 } end)
  end
  try("restitution -1", function() w:ball { radius = 1, restitution = -1 } end)
  try("restitution 2", function() w:ball { radius = 1, restitution = 2 } end)
  try("friction -1", function() w:ball { radius = 1, friction = -1 } end)
  try("hinge without an axis", function() w:hinge { a = body, at = { 0, 0, 0 }, axis = { 0, 0, 0 } } end)
  try("plane without a normal", function() w:plane { normal = { 0, 0, 0 } } end)
  try("spring of -1 N/m", function() w:spring { a = body, at_b = { 0, 0, 0 }, stiffness = -1 } end)
  try("rotation about nothing", function() w:ball { radius = 1, rotation = digbox.quat { axis = { 0, 0, 0 }, angle = 1 } } end)
  return list
end

return {
  id = "B24", title = "invalid input", seconds = 1, fast = 1, chaotic = true,
  build = function(place)
    local s = { bodies = {}, taken = 0, changed = 0, names = "" }
    place:floor {}
    for i = 1, 100 do s.bodies[i] = place:ball { radius = 0.2, at = { i % 10, 0.3 + 0.1 * (i % 7), i // 10 } } end
    return s
  end,
  act = function(s, _, k)
    if k ~= 10 then return end
    for _, attempt in ipairs(attempts(s.world, s.bodies[50])) do
      local before, count = s.world:checksum(), #s.world:bodies()
      if pcall(attempt[2]) then s.taken, s.names = s.taken + 1, s.names .. " " .. attempt[1] end
      if #s.world:bodies() ~= count or s.world:checksum() ~= before then s.changed = s.changed + 1 end
    end
  end,
  finish = function(s)
    return { hard.most("taken without an error:" .. s.names, s.taken, 0), hard.most("that changed the world", s.changed, 0) }
  end,
}
