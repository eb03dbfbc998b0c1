-- digbox/test.lua - the scenario kit: scenarios, what they wait for, what they expect, and the report when one fails.

local core = ...
local next, type, pcall, error = next, type, pcall, error

local test = {}
local Scenario = {}
local current                    -- the scenario that runs, or nil
core.scenarios = {}
core.globals.digbox = core.digbox       -- specs may leave out the require

local picture_size = { 640, 360 }
local golden_size = { 320, 180 }
local REPLAY_PATIENCE = 60       -- s; what takes longer to fail is not run again for its replay
local levels = { "sketch", "play", "study", "reference" }

-- ---- registering ----

local function register(name, fn, accuracy)
  if type(name) ~= "string" or name == "" then core.fail("test.scenario wants a name; got %s", core.type(name)) end
  if type(fn) ~= "function" then core.fail("test.scenario('%s') wants a function; got %s", name, core.type(fn)) end
  for _, other in ipairs(core.scenarios) do
    if other.name == name then core.fail("test.scenario: there is a scenario '%s' already (%s)", name, other.where) end
  end
  local entry = { name = name, fn = fn, accuracy = accuracy, where = (core.where():gsub(": $", "")) }
  core.scenarios[#core.scenarios + 1] = entry
  if core.options.mode ~= "test" and core.options.mode ~= "check" then
    local told = {}
    local passed = core.run_scenario(entry, function(text) told[#told + 1] = text end)
    local text = table.concat(told)
    core.print((passed and "ok    " or "FAIL  ") .. name .. "\n" .. text)
    if not passed then core.raise(6, text) end
  end
end

core.declare("test.scenario", { "A scenario: builds a world, lets it run and checks what should hold.", takes = {
  { "name", "text", "what should hold, in words" }, { "run", "function", "called with the scenario s" } } })
core.declare("test.each_accuracy", { "One scenario for each accuracy.", takes = {
  { "name", "text", "what should hold, in words" }, { "run", "function", "called with s and the name of the accuracy" } } })

-- test.scenario(name, function(s) ... end)
function test.scenario(name, fn) register(name, fn) end

-- test.each_accuracy(name, function(s, accuracy) ... end): one scenario for each level
function test.each_accuracy(name, fn)
  for _, level in ipairs(levels) do register(("%s [%s]"):format(name, level), fn, level) end
end

-- ---- checks ----

local function count_check()
  if current then current.checks = current.checks + 1 end
end

-- Raises with the script's line; a script that catches it has failed all the same.
local function fail(format, ...)
  local text = core.where() .. format:format(...)
  if current and not current.forgiving then current.failure = current.failure or text end
  error(text, 0)
end

-- ---- expectations ----

-- "nan" has no sign that anyone meant, and 0 has none
local function plain(x, format) return x ~= x and "nan" or format:format(x + 0.0) end

local function show(value)
  local kind = type(value)
  if kind == "string" then return ("%q"):format(value) end
  if kind == "number" then
    return math.type(value) == "integer" and ("%d"):format(value) or plain(value, "%.9g")
  end
  if kind ~= "table" then return tostring(value) end
  value = core.thaw(value)
  local parts, named = {}, {}
  for i = 1, #value do parts[i] = show(value[i]) end
  for k, v in next, value do
    if type(k) == "string" then named[#named + 1] = ("%s = %s"):format(k, show(v)) end
  end
  table.sort(named)
  return "{" .. table.concat(table.move(named, 1, #named, #parts + 1, parts), ", ") .. "}"
end

local function unit_of(value)
  return type(value) == "string" and value:match "^%s*[+-]?[%d.]+[eE]?[+-]?%d*%s*(.-)%s*$" or ""
end

-- A bound in SI, and how to write a value beside it: "1 mm/s" -> 0.001 and values in mm/s. `like`: a unit of the same dimension.
local function bound(value, what, like)
  if type(value) == "string" then
    local unit = unit_of(value)
    local si = core.quantity(value, unit ~= "" and like or nil, what)
    local size = unit ~= "" and unit ~= "degC" and core.quantity("1 " .. unit, nil, what) or 1
    return si, function(x) return unit ~= "" and plain(x / size, "%.6g") .. " " .. unit or plain(x, "%.9g") end
  end
  if type(value) ~= "number" then core.fail("%s wants a number or a string with a unit; got %s", what, core.type(value)) end
  return value, function(x) return plain(x, "%.9g") end
end

-- How far off a value may be: a number, a quantity of the dimension of what is wanted, or a share of it: "2 %".
local function tolerance_of(value, wanted, size)
  local what, unit, like = "expect:near.tolerance", unit_of(value), nil
  for _, part in ipairs(type(wanted) == "table" and wanted or { wanted }) do like = like or unit_of(part) ~= "" and unit_of(part) end
  local tol, write
  if unit == "%" then
    tol = core.quantity(value, nil, what) * size
    write = function(x) return x == tol and value or plain(x, "%.9g") end
  elseif unit == "degC" then                     -- a difference
    return tolerance_of(value:gsub("degC", "K"), wanted, size)
  else
    tol, write = bound(value, what, like and (like == "degC" and "K" or like))
  end
  local sound = tol >= 0                -- false for NaN
  if not sound then core.fail("%s = %s, must be >= 0", what, write(tol)) end
  return tol, write
end

local function same(a, b, depth)
  if a == b then return true end
  if core.type(a) == "vector" then a = { a.x, a.y, a.z } end
  if core.type(b) == "vector" then b = { b.x, b.y, b.z } end
  if type(a) ~= "table" or type(b) ~= "table" or depth > 20 then return false end
  a, b = core.thaw(a), core.thaw(b)
  for k, v in next, a do
    if not same(v, b[k], depth + 1) then return false end
  end
  for k in next, b do
    if a[k] == nil then return false end
  end
  return true
end

local function number_of(e, what)
  if type(e.value) ~= "number" then fail("%s: the value is %s, not a number", what, show(e.value)) end
  return e.value
end

local Expect = {}

function Expect.is(e, wanted)
  count_check()
  if not same(e.value, wanted, 0) then fail("expected %s, got %s", show(wanted), show(e.value)) end
end

function Expect.is_not(e, unwanted)
  count_check()
  if same(e.value, unwanted, 0) then fail("expected anything but %s", show(unwanted)) end
end

-- Three numbers in a list are a vector, too
local function vector_of(value)
  if core.type(value) == "vector" then return value end
  if type(value) ~= "table" or #value ~= 3 or core.type(value) ~= "table" then return nil end
  for i = 1, 3 do
    if type(value[i]) ~= "number" then return nil end
  end
  return core.vec(value[1], value[2], value[3])
end

function Expect.near(e, wanted, tolerance)
  count_check()
  if tolerance == nil then core.fail "expect:near wants a tolerance, too: how far off it may be" end
  local got_vector = vector_of(e.value)
  if got_vector then
    if type(wanted) == "number" or type(wanted) == "string" then
      core.fail("expect:near: %s is a vector, %s is none", show(e.value), show(wanted))
    end
    local v = core.vec(wanted)
    local tol, write = tolerance_of(tolerance, wanted, #v)
    local off = #(got_vector - v)
    local close = off <= tol            -- false for NaN
    if not close then fail("expected %s within %s, got %s (off by %s)", tostring(v), write(tol), show(e.value), write(off)) end
    return
  end
  local want, write = bound(wanted, "expect:near")
  local tol, write_tol = tolerance_of(tolerance, wanted, math.abs(want))
  local got = number_of(e, "expect:near")
  local close = math.abs(got - want) <= tol
  if not close then
    fail("expected %s within %s, got %s (off by %s)", write(want), write_tol(tol), write(got), write_tol(math.abs(got - want)))
  end
end

local function compare(name, words, holds)
  Expect[name] = function(e, limit)
    count_check()
    local want, write = bound(limit, "expect:" .. name)
    local got = number_of(e, "expect:" .. name)
    if not holds(got, want) then fail("expected %s %s, got %s", words, write(want), write(got)) end
  end
end

compare("below", "below", function(a, b) return a < b end)
compare("above", "above", function(a, b) return a > b end)
compare("at_most", "at most", function(a, b) return a <= b end)
compare("at_least", "at least", function(a, b) return a >= b end)

function Expect.between(e, low, high)
  count_check()
  local lo, write = bound(low, "expect:between")
  local hi = bound(high, "expect:between", unit_of(low) ~= "" and unit_of(low) or nil)
  local ordered = lo <= hi              -- false for NaN
  if not ordered then core.fail("expect:between: %s is above %s, the lower bound comes first", show(low), show(high)) end
  local got = number_of(e, "expect:between")
  if not (got >= lo and got <= hi) then fail("expected %s to %s, got %s", write(lo), write(hi), write(got)) end
end

function Expect.is_empty(e)
  count_check()
  local empty = e.value == "" or type(e.value) == "table" and next(e.value) == nil
  if not empty then fail("expected nothing in it, got %s", show(e.value)) end
end

-- A text that holds another, a list that holds a value
function Expect.contains(e, part)
  count_check()
  local found = false
  if type(e.value) == "string" then
    found = e.value:find(tostring(part), 1, true) ~= nil
  elseif type(e.value) == "table" then
    for _, v in next, e.value do found = found or same(v, part, 0) end
  end
  if not found then fail("expected %s in it, got %s", show(part), show(e.value)) end
end

-- The function raises an error, in which part stands; returns its text
function Expect.fails(e, part)
  count_check()
  if type(e.value) ~= "function" then fail("expect:fails wants a function; got %s", core.type(e.value)) end
  local outer = current and current.forgiving
  if current then current.forgiving = true end
  local ok, message = pcall(e.value)
  if current then current.forgiving = outer end
  if ok then fail "expected an error, and there was none" end
  if message == core.finished then error(message, 0) end
  local text = tostring(message)
  if part ~= nil and not text:find(tostring(part), 1, true) then fail("expected an error that says %s, got %s", show(part), show(text)) end
  return text
end

core.declare_type("expect", "What test.expect gives: one check of a value; bounds carry units ('1 mm/s').", Expect)
local function check_of(name, help, ...)
  core.declare("expect:" .. name, { help, takes = { ... }, gives = name == "fails" and "string" or nil })
end
local function bounded(name, help) return { name, "any", help, type = "number|string" } end
check_of("is", "Equal, tables by their contents.", { "wanted", "any", "what it should be" })
check_of("is_not", "Anything but that.", { "unwanted", "any", "what it should not be" })
check_of("near", "A number or vector within a tolerance.", { "wanted", "any", "what it should be", type = "number|string|vector" },
  bounded("tolerance", "how far off it may be: SI, with a unit of the same dimension, or a share: '2 %'"))
check_of("between", "Between two bounds, both allowed.", bounded("low", "lower bound"), bounded("high", "upper bound"))
check_of("below", "Smaller than that.", bounded("limit", "bound"))
check_of("above", "Greater than that.", bounded("limit", "bound"))
check_of("at_most", "Not greater than that.", bounded("limit", "bound"))
check_of("at_least", "Not smaller than that.", bounded("limit", "bound"))
check_of("is_empty", "An empty list, table or text.")
check_of("contains", "A text that holds another, or a list that holds a value.", { "part", "any", "what should be in it" })
check_of("fails", "A function that raises an error; gives its text.", { "part", "any", "what should be in it", optional = true })
core.declare("test.expect", { "Begins a check of a value.", takes = { { "value", "any", "what is checked" } }, gives = "expect" })

local expect_meta = {
  __index = function(_, key)
    if key == "value" then return nil end
    if not Expect[key] then core.unknown("expect", "has no check", tostring(key), Expect) end
    return Expect[key]
  end,
  __metatable = false,
}

-- test.expect(value):below "1 mm/s"
function test.expect(value)
  return setmetatable({ value = value }, expect_meta)
end

-- ---- the scenario object ----

local function new_world(s, fields)
  local copy = {}
  for k, v in next, fields or {} do copy[k] = v end
  if copy.accuracy == nil then copy.accuracy = s.accuracy end
  local world = core.digbox.world(copy)
  local state = core.lua_state(world)
  state.scenario = s
  state.log_mask = 0
  core.quiet(world)
  for name, kind in next, core.event_kinds do
    if name ~= "moved" and name ~= "link" and name ~= "unlink" and name ~= "message" then
      state.log_mask = state.log_mask | (1 << kind)
    end
  end
  if s.jitter then state.before_first_step = s.jitter end
  return world
end

local function world_of(s)
  if not s.own_world then s.own_world = new_world(s) end
  return s.own_world
end

-- s.world is the scenario's world; s:world{...} makes a fresh one with options and is s.world from then on.
core.types.world.meta.__call = function(world, s, fields)
  if getmetatable(s) ~= "scenario" then core.fail "a world is not a function (s:world{...} makes one in a scenario)" end
  if s.own_world == world and world.steps == 0 and #world:bodies() == 0 then world:close() end
  s.own_world = new_world(s, fields)
  return s.own_world
end

local scenario_meta = { __metatable = "scenario" }
scenario_meta.__index = function(s, key)
  if key == "world" then return world_of(s) end
  if Scenario[key] then return Scenario[key] end
  if key == "own_world" or key == "jitter" or key == "accuracy" or key == "failure" or key == "perturbed" or key == "forgiving"
    or key == "unsettled" then
    return nil
  end
  core.unknown("scenario", "has no field or method", tostring(key), Scenario, { world = true })
end

core.declare_type("scenario", "What a scenario is given, by habit called s. s:world{...} makes its world with options.", Scenario, {
  world = { "world", "its world, fresh; s:world{...} makes one with options" } })
core.declare("scenario:settle", { "Lets things come to rest, held by something: true, or false and what still moves. What falls fails.",
  takes = { { "time", "real s >=0", "how long, at least a step" } }, gives = "boolean" })
core.declare("scenario:expect_reliable", { "The world has found nothing wrong with itself so far." })
core.declare("scenario:cpu_seconds", { "CPU time of the process so far, s.", gives = "number" })
local CLAIM = { "claim", "text", "what should be, in words" }
core.declare("scenario:eventually", { "Within that time the condition holds; gives after how long.", takes = { CLAIM,
  { "limit", "real s >=0", "how long at most" }, { "condition", "function", "asked before each step" } }, gives = "number" })
core.declare("scenario:always", { "For all that time the condition holds.", takes = { CLAIM,
  { "time", "real s >=0", "for how long" }, { "condition", "function", "asked before each step" } } })

-- ---- rest ----

local SLOW = 0.01                -- m/s  of any point of what is at rest
local FREE = 0.1                 -- of its weight: what is pulled by its weight, within that, is not borne

local function is_dynamic(body) return body ~= nil and body.kind == "dynamic" end

-- Does anything hold up the DIG of b: a joint or a contact with what is no part of a DIG?
local function is_held(world, b)
  for _, k in ipairs(b.dig:links()) do
    if k.bound then return true end
  end
  for _, j in ipairs(world:joints()) do
    local free, other = j.a, j.b
    if not is_dynamic(free) then free, other = other, free end
    if is_dynamic(free) and not is_dynamic(other) and free.dig == b.dig then return true end
  end
  return false
end

-- It is slow at its start and where it turns, but nothing bears its weight.
local function falls(world, b)
  local weight = world.gravity * (b.mass * b.gravity_scale)
  return #weight > 0 and #(b.force - weight) < FREE * #weight and not is_held(world, b)
end

-- m/s  Of its fastest point, at most
local function speed_of(b)
  return #b.velocity + #b.spin * #(b.bounds.high - b.bounds.low) / 2
end

-- s:settle "1 s": lets things come to rest for so long, at least a step -> true, or false and what still moves
-- What falls with nothing to hold it up has no rest to come to: the scenario goes on, but fails, by what it finds itself or by this.
-- What swings, rolls or is driven may still move.
function Scenario.settle(s, time)
  local world, limit = world_of(s), core.seconds(time, "s:settle")
  world:run(math.max(limit, world.frame))
  local fastest, most
  for _, b in ipairs(world:bodies()) do
    if is_dynamic(b) and not b.asleep and b.mode ~= "resting" then
      if falls(world, b) then
        local text = ("s:settle: after %g s %s falls at %.3g m/s: nothing holds it up"):format(limit, tostring(b), b.speed)
        if current and current.forgiving then fail("%s", text) end
        s.unsettled = s.unsettled or core.where() .. text
        return false, b
      end
      local speed = speed_of(b)
      if speed > SLOW and not (most and most >= speed) then fastest, most = b, speed end
    end
  end
  if not fastest then return true end
  s.notes[#s.notes + 1] = ("s:settle: at t = %.6g s %s still moved at %.3g m/s"):format(world.time, tostring(fastest), most)
  return false, fastest
end

-- s:expect_reliable(): the world has found nothing wrong with itself so far (world:warnings())
function Scenario.expect_reliable(s)
  count_check()
  local list = world_of(s):warnings()
  if #list > 0 then fail("the run became unreliable: %s", core.describe_warning(list[1])) end
end

-- s:cpu_seconds(): CPU time of the process so far, for measurements of what accuracy costs; 0 where it is not known
function Scenario.cpu_seconds()
  local clock = rawget(core, "cpu_seconds")
  return clock and clock() or 0
end

local function check_claim(what, text, condition)
  if type(text) ~= "string" then core.fail("%s wants a text that says what should be; got %s", what, core.type(text)) end
  if type(condition) ~= "function" then core.fail("%s wants a function; got %s", what, core.type(condition)) end
end

-- s:eventually("the ball is asleep", "5 s", function() return ball.asleep end)
function Scenario.eventually(s, text, time, condition)
  check_claim("s:eventually", text, condition)
  local world, limit = world_of(s), core.seconds(time, "s:eventually")
  local begin = world.time
  count_check()
  repeat
    if condition() then return world.time - begin end
    if world.time - begin >= limit - 1e-9 then break end
    world:step()
  until false
  fail("not within %g s: %s", limit, text)
end

-- s:always("it stays", "1 s", function() return table_.dig == ball.dig end)
function Scenario.always(s, text, time, condition)
  check_claim("s:always", text, condition)
  local world, limit = world_of(s), core.seconds(time, "s:always")
  local begin = world.time
  count_check()
  repeat
    if not condition() then fail("no more after %.6g s: %s", world.time - begin, text) end
    if world.time - begin >= limit - 1e-9 then return end
    world:step()
  until false
end

-- ---- golden pictures ----

local function slug(text)
  return (text:lower():gsub("[^%w]+", "_"):gsub("^_", ""):gsub("_$", ""):sub(1, 80))
end

local function golden_paths(s, name)
  local options = core.options
  local base = options.script_name:gsub("%.lua$", "")
  local inner = ("golden/%s/%s-%s.png"):format(base, slug(s.name), slug(name))
  return (options.script:match "^(.*/)" or "") .. inner, inner
end

-- Exact where the golden was drawn by the same renderer; else each 8x8 tile within 10 of 255 levels in the mean, but for 1 in 200.
-- Ids are no shades: whatever drew them, a pixel shows the same body or another, and no more than 1 in 1000, at outlines, may change.
local function compare_golden(golden, picture, layer)
  local strict = core.png_text(golden, "Renderer") == core.renderer()
  local c = core.compare_pictures(golden, picture, 10)
  if c.why then return c.why end
  if c.same then return nil end
  if layer == "id" then
    if not strict and c.pixels * 1000 <= c.all then return nil end
    return ("%d of %d pixels show another body, the first at %s"):format(c.pixels, c.all, c.first)
  end
  if strict then return ("differs, tile at %s by %.3g levels (same renderer: must be exact)"):format(c.where, c.worst) end
  if c.bad * 200 <= c.tiles then return nil end
  return ("%d of %d tiles differ, the worst at %s by %.3g levels"):format(c.bad, c.tiles, c.where, c.worst)
end

local golden_fields = { camera = { "any", "by which it is seen", type = "camera" },
  size = { "any", "in pixels; default {320, 180}", type = "integer[]" }, overlay = { "any", "as world:render", type = "string|string[]" },
  layer = { "text", "colour, or id: which body is seen where, whatever it looks like", of = { colour = 0, id = 2 }, default = "colour" } }
core.declare("scenario:golden", { "A picture equal to the one kept beside the spec; --update-goldens keeps that of today.",
  takes = { { "name", "text", "which picture" } }, fields = golden_fields, optional = true })

-- s:golden("after", {camera = cam, size = {320, 180}, layer = "colour" | "id"})
-- A picture compared with golden/<spec>/<scenario>-<name>.png beside the spec; --update-goldens writes it.
function Scenario.golden(s, name, fields)
  if type(name) ~= "string" then core.fail("s:golden wants a name; got %s", core.type(name)) end
  if s.jitter then return end
  local f = core.check(fields or {}, "s:golden", golden_fields)
  local world = world_of(s)
  local golden, inner = golden_paths(s, name)
  local picture = world:render { to = inner, camera = f.camera, size = f.size or golden_size, overlay = f.overlay,
    layer = f.layer }
  if core.options.update_goldens then
    core.make_folders(golden)
    core.write(golden, core.read(picture))
    s.notes[#s.notes + 1] = "wrote " .. golden
  elseif not core.exists(golden) then
    s.notes[#s.notes + 1] = ("no golden yet: %s (look at %s, then --update-goldens)"):format(golden, picture)
    return
  end
  count_check()
  local why = compare_golden(golden, picture, f.layer)
  if why then fail("golden '%s': %s\n  golden:  %s\n  now:     %s", name, why, golden, picture) end
  local drawn = core.png_text(golden, "Renderer")
  if drawn ~= core.renderer() then
    s.notes[#s.notes + 1] = ("golden '%s' holds, but only nearly: it was drawn by %s"):format(name, drawn or "an unknown renderer")
  end
end

-- ---- perturbation ----

-- Numbers in [-1, 1] that depend on the seed alone (xorshift64*: Vigna 2016).
local function random_numbers(seed)
  local x = (seed * 0x9E3779B97F4A7C15) | 1
  return function()
    x = x ~ (x << 13)
    x = x ~ (x >> 7)
    x = x ~ (x << 17)
    return ((x * 0x2545F4914F6CDD1D) >> 11) / (1 << 52) - 1
  end
end

-- Bodies held together by joints move together; those held by the world stay.
local function joined_groups(world)
  local group, fixed = {}, {}
  local function find(b)
    while group[b] and group[b] ~= b do b = group[b] end
    return b
  end
  for _, j in ipairs(world:joints()) do
    local a, b = j.a, j.b
    if a and b then
      group[find(a)] = find(b)
    elseif a or b then
      fixed[a or b] = true
    end
  end
  local held = {}
  for _, b in ipairs(world:bodies()) do
    if fixed[b] or b.kind ~= "dynamic" then held[find(b)] = true end
  end
  return find, held
end

-- Moves every free dynamic body a little; never down, so that what stands does not start inside what it stands on.
local function jitter_by(amount, seed)
  return function(world)
    local random, find, held = random_numbers(seed), joined_groups(world)
    local g = world.gravity
    local up = #g > 0 and -g:normalized() or nil
    local offsets = {}
    for _, b in ipairs(world:bodies()) do
      if b.kind == "dynamic" then
        local root = find(b)
        if not offsets[root] then
          local d = core.vec(random(), random(), random()) * amount
          if up and d:dot(up) < 0 then d = d - up * (2 * d:dot(up)) end
          offsets[root] = d
        end
        if not held[root] then b:teleport { at = b.position + offsets[root] } end
      end
    end
  end
end

local perturb_fields = { seeds = { "int 1 >0", "how often", default = 5 },
  position = { "real m >0", "by how much at most each body starts elsewhere", default = 1e-3 } }
core.declare("scenario:perturb", { "The whole scenario again, with starts a little elsewhere.", fields = perturb_fields })

-- s:perturb{seeds = 5, position = "1 mm"}: the whole scenario again, as often, with jittered starts
function Scenario.perturb(s, fields)
  local f = core.check(fields, "s:perturb", perturb_fields)
  if s.jitter then return end
  s.perturbed = { seeds = f.seeds, position = f.position }
end

-- ---- running one ----

local function close_world(s)
  local world = rawget(s, "own_world")
  if world and core.is_free(world) then
    core.lua_state(world).in_handler, core.lua_state(world).in_task = nil, nil
    world:close()
  end
end

local function new_scenario(entry, jitter)
  return setmetatable({ name = entry.name, accuracy = entry.accuracy, checks = 0, notes = {}, jitter = jitter }, scenario_meta)
end

local function dot_of(world)
  local lines = { "graph digs {" }
  for _, d in ipairs(world:digs()) do
    lines[#lines + 1] = ('  subgraph cluster_%d { label = "DIG %d (%s)";'):format(d.id, d.id, d.awake and "awake" or "asleep")
    for _, b in ipairs(d:members()) do lines[#lines + 1] = ("    %q;"):format(tostring(b)) end
    lines[#lines + 1] = "  }"
    for _, k in ipairs(d:links()) do
      lines[#lines + 1] = ('  %q -- %q [label = "%s%s, %.4g N"];'):format(tostring(k.a), tostring(k.b), k.kind,
        k.joint and " " .. tostring(k.joint) or "", #k.effort)
    end
  end
  lines[#lines + 1] = "}"
  return table.concat(lines, "\n") .. "\n"
end

-- What files of a scenario, or of its entry in the list, are called.
local function base_of(s)
  return ("%s-%s"):format((core.options.script_name:gsub("%.lua$", "")), slug(s.name))
end

-- The command that runs it again
local function command_of(s)
  return ("again:   digbox test %s -k '%s'"):format(core.options.script, (s.name:gsub("'", "'\\''")))
end

-- What is left of a failed scenario: the last events, a picture, the DIGs.
local function autopsy(s, lines)
  local world = rawget(s, "own_world")
  local base = base_of(s)
  if world and core.is_free(world) then
    local state = core.lua_state(world)
    lines[#lines + 1] = ("at t = %.6g s, step %d"):format(world.time, world.steps)
    local log = state.event_log
    if #log > 0 then lines[#lines + 1] = "last events:" end
    for i = math.max(1, #log - 7), #log do lines[#lines + 1] = "  " .. log[i] end
    local drawn, path = pcall(world.render, world, { to = base .. ".png", size = picture_size })
    lines[#lines + 1] = drawn and "picture: " .. path or nil
    local dumped, place = pcall(core.out_path, base .. ".dot")
    if dumped and pcall(function() core.write(place, dot_of(world)) end) then lines[#lines + 1] = "DIGs:    " .. place end
  end
end

function core.over_sim_limit(limit)
  fail("used up its %g s of simulated time; raise --sim-limit or simulate less", limit)
end

local function run_once(entry, jitter)
  local s = new_scenario(entry, jitter)
  current = s
  local ok, message = xpcall(entry.fn, function(m)
    if type(m) == "string" then return core.hint(m) end
    if m == core.finished then return m end
    return core.where() .. ("error was called with a %s, must be with a text that says what is wrong"):format(type(m))
  end, s, entry.accuracy)
  current = nil
  if not ok and message == core.finished then ok = true end
  local fault = core.take_faults()
  if ok and fault then ok, message = false, ("%s: %s"):format(entry.where, fault) end
  if ok and s.failure then ok, message = false, s.failure end
  if ok and s.unsettled then ok, message = false, s.unsettled end
  if ok and s.checks == 0 then ok, message = false, entry.where .. ": the scenario checks nothing" end
  return s, ok, message
end

-- A limit has tripped while a scenario ran: its line is in the report already, this comes behind it.
local report_stop = core.report_stop
function core.report_stop()
  local s, lines = current, {}
  core.stopping = true
  if s and core.report and not core.stopped() then
    local world = rawget(s, "own_world")
    if world and core.is_free(world) then core.lua_state(world).in_handler, core.lua_state(world).in_task = nil, nil end
    pcall(autopsy, s, lines)
    lines[#lines + 1] = "replay:  none, since it was stopped; --sim-limit stops it at a time of its world, with one"
    lines[#lines + 1] = command_of(s)
    core.report("\n" .. table.concat(lines, "\n"))
  end
  report_stop()
end

-- A scenario does the same when it is run again: this time with a recorder.
local function keep_replay(entry, jitter, lines, took)
  if took > REPLAY_PATIENCE then
    lines[#lines + 1] = ("replay:  none, since the scenario takes %.0f s"):format(took)
    return
  end
  local path = core.out_path(base_of(entry) .. ".replay")
  core.print "(the same again, for its replay)"
  core.options.replay = path
  local again = run_once(entry, jitter)
  pcall(core.finish_replay)
  core.options.replay = nil
  pcall(close_world, again)
  if core.exists(path) then lines[#lines + 1] = ("replay:  %s (digbox view %s -o page.html)"):format(path, path) end
end

-- core.run_scenario(entry[, report]) -> whether it passed; what there is to say is given to report(text), in order
function core.run_scenario(entry, report)
  report = report or core.report
  local begin, jitter = core.clock(), nil
  local s, ok, message = run_once(entry)
  local lines, perturbed = {}, s.perturbed
  for i = 1, ok and perturbed and perturbed.seeds or 0 do
    close_world(s)
    local again
    begin, jitter = core.clock(), jitter_by(perturbed.position, i)
    again, ok, message = run_once(entry, jitter)
    again.notes = table.move(s.notes, 1, #s.notes, 1, {})
    s = again
    if not ok then
      message = ("%s\nperturbed by up to %g m, seed %d of %d"):format(message, perturbed.position, i, perturbed.seeds)
      break
    end
  end
  if not ok then
    report(tostring(message))          -- now: a limit may trip over its picture or its replay, which must not hide it
    local took = core.clock() - begin
    pcall(autopsy, s, lines)
    pcall(close_world, s)
    pcall(keep_replay, entry, jitter, lines, took)
    lines[#lines + 1] = command_of(s)
  end
  for _, note in ipairs(s.notes) do
    if not (ok and note:find("^s:settle")) then lines[#lines + 1] = note end       -- of use where something failed
  end
  pcall(close_world, s)
  if #lines > 0 then report((ok and "" or "\n") .. table.concat(lines, "\n")) end
  return ok
end

setmetatable(test, {
  __index = function(_, key) core.unknown("digbox.test", "has no function", tostring(key), test) end,
  __metatable = false,
})
return test
