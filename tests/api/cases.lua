-- tests/api/cases.lua - cases of handles, callbacks and odd tables that need a view from outside (run by tests/unit/test_api.c): tables
-- that lie, handles that nobody keeps, a million handles, every function with 0 to 20 arguments, errors inside every callback.
--
-- Gets the core table; gives a list of problems and how many checks were made. docs/security.md has the list of all cases.

local core = ...
core.commands, core.exit_codes = {}, ""
local api, digbox = core.use "api", core.digbox
local problems, checks = {}, 0

local function check(holds, format, ...)
  checks = checks + 1
  if not holds then problems[#problems + 1] = format:format(...) end
end

-- ---- H12: a handle owns nothing ----

do
  local world = digbox.world {}
  world:floor {}
  for i = 1, 20 do world:ball { name = "b" .. i, radius = 0.1, at = { i, 1, 0 } } end
  collectgarbage()
  collectgarbage()
  local seen = 0
  world:find("b3"):on("contact_begin", function() seen = seen + 1 end)
  collectgarbage()
  world:run(1)
  check(#world:bodies() == 21 and world:find("b7").position.y < 1, "H12: bodies went with their handles")
  check(seen > 0, "H12: a handler went with the handle that it was given to")
  world:close()
end

-- ---- H13: bodies and handles come and go, memory does not grow ----

do
  local world = digbox.world {}
  local function churn(n)
    for i = 1, n do
      world:ball { radius = 0.1, at = { i % 7, 0, 0 } }:remove()
      if i % 100 == 0 then world:step() end             -- till then it is an event to come that they were removed
    end
    collectgarbage()
    collectgarbage()
    return collectgarbage "count", world:stats().bytes
  end
  churn(2000)
  local lua_before, world_before = churn(2000)
  local lua_after, world_after = churn(20000)
  check(lua_after - lua_before < 64, "H13: %.0f KiB of Lua's memory are lost with 20,000 bodies", lua_after - lua_before)
  check(world_after == world_before, "H13: the world grew by %d bytes", world_after - world_before)
  local first, handles = world:ball { radius = 0.1 }, {}
  for i = 1, 100000 do handles[i] = first end
  check(handles[1] == handles[100000] and world:bodies()[1] == first, "H13: a body has two handles")
  world:close()
end

-- ---- A17: tables that lie are read as they are, and never for long ----

do
  local world = digbox.world {}
  local asked = 0
  local liar = setmetatable({}, {
    __index = function() asked = asked + 1 error "asked" end, __len = function() asked = asked + 1 return 2 ^ 60 end,
    __pairs = function() asked = asked + 1 return function() return 1, 1 end end, __newindex = function() asked = asked + 1 end })
  local cyclic = {}
  cyclic[1], cyclic.at, cyclic.size, cyclic.points = cyclic, cyclic, cyclic, cyclic
  local before, began = world:checksum(), os.clock()
  for _, e in ipairs(api.entries) do
    if e.owner == "world" and e.mark == ":" and not e.name:find "render" and not e.name:find "record" then
      for _, odd in ipairs { liar, cyclic } do
        if next(api.fields_of(e)) and not e.optional then
          local ok = pcall(world[e.short], world, odd)
          check(not ok or odd == liar and pcall(world[e.short], world, {}), "A17: %s takes a table that lies", e.name)
        end
      end
    end
  end
  check(asked == 0, "A17: a table of fields was asked %d times by its metatable", asked)
  check(world:checksum() == before, "A17: a refused table changed the world")
  check(os.clock() - began < 5, "A17: tables that lie took %.1f s", os.clock() - began)
  world:close()
end

-- ---- H14: 0 to 20 arguments, with 200 values below them on the stack ----

local values = { 5, "x", {}, true, function() end, 0 / 0, { 1, 2, 3 } }

local function stand_in(owner, world, things)
  if owner == "world" then return world end
  return things[owner]
end

do
  local world = digbox.world {}
  local body, other = world:box { name = "crate", size = 1 }, world:ball { radius = 0.5, at = { 3, 0, 0 } }
  local hinge = world:hinge { a = body, b = other, at = { 1, 0, 0 }, axis = { 0, 1, 0 } }
  local things = { body = body, joint = hinge, DIG = body.dig, region = world:region { sphere = { radius = 1 } },
    vector = digbox.vec(1, 2, 3), rotation = digbox.quat { angle = 1 }, link = world:link { a = body, b = other, layer = "thermal" } }
  local skipped = {}
  for _, name in ipairs { "world:close", "world:render", "world:record", "world:save", "world:run", "digbox.args", "body:remove",
    "joint:remove", "region:remove", "link:remove" } do skipped[name] = true end
  local filler = {}
  for i = 1, 200 do filler[i] = i end
  local function call_deep(f, n, value, subject)
    local list = { subject }
    for _ = 1, n do list[#list + 1] = value end
    local function deep(...)
      local ok, message = pcall(f, table.unpack(list, 1, n + (subject and 1 or 0)))
      return ok, message, select("#", ...), (select(200, ...))
    end
    return deep(table.unpack(filler, 1, 200))
  end
  for _, e in ipairs(api.entries) do
    local subject = stand_in(e.owner, world, things)
    local f = e.owner == "digbox" and core.digbox[e.short] or subject and subject[e.short]
    if type(f) == "function" and not skipped[e.name] then
      for n = 0, 20 do
        local value = values[n % #values + 1]
        local ok, message, count, last = call_deep(f, n, value, e.owner ~= "digbox" and subject or nil)
        check(count == 200 and last == 200, "H14: %s with %d arguments disturbed the stack", e.name, n)
        check(ok or type(message) == "string", "H14: %s with %d arguments: an error that is a %s", e.name, n, type(message))
      end
    end
  end
  check(pcall(world.check, world), "H14: the world is not sound")
  world:close()
end

-- ---- H9, H10, H15: each function that calls back, with a callback that raises, yields or recurses ----

do
  local function recurse(n) return 1 + recurse(n + 1) end
  local callbacks = { raises = function() error "oops" end, raises_table = function() error({}) end,
    yields = function() coroutine.yield(1) end, recurses = function() return recurse(1) end }
  local ways = {
    handler = function(world, f) world:find "ball":on("contact_begin", f) world:run(1) end,
    world_handler = function(world, f) world:on("contact_begin", f) world:run(1) end,
    effect = function(world, f) world:add_effect { name = "own", step = f } world:step(3) end,
    settle = function(world, f) world:add_effect { name = "own", stage = "settle", step = f } world:step(3) end,
    members = function(world, f) world:add_effect { name = "own", step = function() end, bodies = f } world:step(3) end,
    region = function(world, f)
      world:region { sphere = { radius = 5 }, laws = { force = f } }
      world:step(3)
    end,
    message = function(world, f)
      world:find "ball":on("message", f)
      world:find "ball":send(world:find "ball", "hello")
      world:step(2)
    end,
  }
  for way, begin in next, ways do
    for name, callback in next, callbacks do
      local world = digbox.world {}
      world:floor {}
      world:ball { name = "ball", radius = 0.1, at = { 0, 0.3, 0 } }
      local co = coroutine.create(function() return pcall(begin, world, callback) end)
      local resumed, ok, message = coroutine.resume(co)
      check(resumed and coroutine.status(co) == "dead", "H10: %s that %s: the call was left by a yield", way, name)
      check(ok == false and message ~= nil, "H15: %s that %s: no error came out", way, name)
      check(pcall(world.check, world), "H15: %s that %s: the world is not sound", way, name)
      check(pcall(world.close, world), "H15: %s that %s: the world cannot be closed", way, name)
    end
  end
end

-- ---- H11: callbacks that are none, and very many ----

do
  local world = digbox.world {}
  world:floor {}
  local ball = world:ball { name = "ball", radius = 0.1, at = { 0, 0.1, 0 } }
  local callable = setmetatable({}, { __call = function() end })
  for _, bad in ipairs { false, 5, "x", callable, ball, world } do
    for what, call in next, {
      ["world:on"] = function() world:on("impact", bad) end, ["body:on"] = function() ball:on("impact", {}, bad) end,
      ["world:spawn"] = function() world:spawn(bad) end,
      ["world:add_effect"] = function() world:add_effect { name = "bad", step = bad } end,
      ["world:region"] = function() world:region { sphere = { radius = 1 }, laws = { force = bad } } end,
      ["world:run"] = function() world:run { seconds = 1, stop_when = bad } end } do
      local ok, message = pcall(call)
      check(not ok and type(message) == "string" and message:find "function", "H11: %s with a %s: %s", what, type(bad), tostring(message))
    end
  end
  local seen, off = 0, {}
  for i = 1, 1e5 do off[i] = world:on("message", function() seen = seen + 1 end) end
  ball:send(ball, "hello")
  world:step()
  check(seen == 1e5, "H11: %d of 100,000 handlers were called", seen)
  for i = 2, #off do off[i]:off() end
  seen = 0
  ball:send(ball, "hello")
  world:step()
  check(seen == 1, "H11: %d handlers were called that are off", seen - 1)
  world:close()
end

return problems, checks
