-- A13 a spinning sphere strikes another in the middle; e = 0.5, mu = 0.3. The normal impulse is Jn = 0.75, the tangential one
-- Jt = min(w R / 7, mu Jn): the bound takes the whole normal impulse, restitution included.
local radius, e, mu = 0.5, 0.5, 0.3

local function collision(letter, spin)
  local jn = (1 + e) / 2
  local jt = math.min(spin * radius / 7, mu * jn)
  local turn = jt * radius / (0.4 * radius * radius)
  return {
    id = "A13" .. letter, title = ("collision with spin %g rad/s"):format(spin), metric = "m/s", scale = 1, seconds = 1,
    world = { gravity = { 0, 0, 0 } }, conserves = { momentum = true, angular = true },
    goal = { fast = { 1e-12, 0.12 }, accurate = { 1e-12, 0.12 } },
    build = function(world)
      local function sphere(x, v, w)
        return world:ball { radius = radius, mass = 1, at = { x, 0, 0 }, velocity = { v, 0, 0 }, spin = { 0, 0, w },
                            friction = mu, restitution = e }
      end
      return { a = sphere(-1.3, 1, spin), b = sphere(0, 0, 0) }
    end,
    finish = function(s)
      return { error = math.max(#(s.a.velocity - { 1 - jn, -jt, 0 }), #(s.b.velocity - { jn, jt, 0 }),
                                #(s.a.spin - { 0, 0, spin - turn }) * radius, #(s.b.spin - { 0, 0, -turn }) * radius) }
    end,
  }
end

return { collision("a", 10), collision("b", 1) }
