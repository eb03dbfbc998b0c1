-- A03 blocks slide to rest: v^2 / (2 mu g) in 1.02 s, straight on, whatever the heading. A03 is one block at 30 degrees;
-- A03h has headings 0, 15, 30 and 45, whose distances must agree.
local exact = require "exact"

local mu, speed = 0.4, 4
local distance = speed ^ 2 / (2 * mu * exact.g)         -- 2.0387359836901121 m

local function build_for(headings)
  return function(world)
    world:plane { normal = { 0, 0, 1 }, friction = mu }
    local s = { blocks = {} }
    for i, degrees in ipairs(headings) do
      local a, y = math.rad(degrees), 20 * (i - 1)
      s.blocks[i] = { start = { 0, y, 0.1 }, along = { math.cos(a), math.sin(a), 0 }, body = world:box {
        size = { 1, 1, 0.2 }, mass = 1, friction = mu, at = { 0, y, 0.1 },
        velocity = { speed * math.cos(a), speed * math.sin(a), 0 } } }
    end
    return s
  end
end

local function finish(s)
  local worst, least, most, heading = 0, math.huge, 0, 0
  for _, b in ipairs(s.blocks) do
    local d = b.body.position - b.start
    worst = math.max(worst, math.sqrt((d.x - distance * b.along[1]) ^ 2 + (d.y - distance * b.along[2]) ^ 2 + d.z ^ 2))
    least, most = math.min(least, #d), math.max(most, #d)
    heading = math.max(heading, math.abs(math.deg(math.atan(d.y * b.along[1] - d.x * b.along[2], d.x * b.along[1] + d.y * b.along[2]))))
  end
  return { error = worst / distance, heading = heading, spread = most - least }
end

local goal = { fast = { 1e-8, 0.20 }, accurate = { 1e-11, 0.5 } }
return {
  { id = "A03", title = "block sliding to rest, heading 30 degrees", metric = "relative", scale = 1, seconds = 2,
    build = build_for { 30 }, finish = finish, goal = goal },
  { id = "A03h", title = "blocks sliding to rest, headings 0, 15, 30, 45", metric = "relative", scale = 1, seconds = 2,
    build = build_for { 0, 15, 30, 45 }, finish = finish },
}
