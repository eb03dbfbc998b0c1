-- digbox/message.lua - sending messages: to a body, to neighbours, to a DIG, along links, along a path, into a region.
--
-- A message carries a name and up to four numbers. `after` delays it; who gets it is found when it is delivered.

local core = ...
local type = type

local body, dig = core.types.body.methods, core.types.DIG.methods

local spec = {
  name = { "any", "what the message is called", type = "string" },
  value = { "any", "a number, or up to four", type = "number|number[]" },
  after = { "real s >=0", "delay; who gets it is found then" },
  route = { "text", "to whom it goes", of = { "to", "neighbours", "dig", "flood", "path", "region" } },
  to = { "body", "the body that gets it, or the end of the path" },
  region = { "any", "to all bodies inside", type = "region" }, layer = { "text", "along the links of that layer", of = core.layer_names },
  kind = { "text", "along links of that kind only", of = core.link_kind_names }, hops = { "int 1 >0", "at most so many links far" },
  transform = { "any", "what a link does to the value: a factor, 'ratio', or a function(value, hop, from, to)",
    type = "number|string|function" } }
local named = { { "name", "text", "what the message is called" },
  { "value", "any", "a number, or up to four", optional = true, type = "number|number[]" } }

-- The fields that a call may have, out of those above
local function only(...)
  local fields = {}
  for _, name in ipairs { ... } do fields[name] = spec[name] end
  return fields
end

local function post(handle, what, fields)
  return core.post(handle, what, fields)
end

local sends = only("name", "value", "after", "route", "to", "region", "layer", "kind", "hops", "transform")

-- What each route needs besides name, value and after
local wants = { to = { to = true }, neighbours = { layer = true, kind = true }, dig = { layer = true },
  flood = { layer = true, kind = true, hops = true, transform = true },
  path = { to = true, layer = true, kind = true }, region = { region = true } }
local needs = { to = "to", path = "to", region = "region" }

local function send_by_route(from, fields)
  local f = core.check(fields, "body:send", sends)
  f.route = f.route or f.to ~= nil and "to" or f.region ~= nil and "region"
  if not f.route then core.fail "body:send: route is missing (to, neighbours, dig, flood, path or region)" end
  if not wants[f.route] then core.unknown("body:send:", "unknown route", f.route, wants) end
  local own = wants[f.route]
  for _, name in ipairs { "to", "region", "layer", "kind", "hops", "transform" } do
    if f[name] ~= nil and not own[name] then core.fail("body:send: route = '%s' has no %s", f.route, name) end
  end
  local need = needs[f.route]
  if need and f[need] == nil then core.fail("body:send: route = '%s' needs %s", f.route, need) end
  if f.route == "flood" and type(f.transform) == "function" then
    core.fail "body:send: a transform that is a function goes with body:flood"
  end
  f.from = from
  post(from, "body:send", f)
  return from
end

local delayed = only("after")
core.declare("body:send", { "Sends a message: to a body, or as the field route says.", fields = sends, gives = "body", also = {
  { takes = { { "to", "body", "who gets it" }, named[1], named[2] }, fields = delayed, optional = true } } })

-- body:send(to, name, value, {after=}) -> body
-- body:send{route = "to" | "neighbours" | "dig" | "flood" | "path" | "region", name=, value=, after=, to=, region=, layer=, kind=,
--           hops=, transform=} -> body
function body.send(from, to, name, value, fields)
  if type(to) == "table" and core.type(to) == "table" and name == nil then return send_by_route(from, to) end
  local f = core.check(fields or {}, "body:send", delayed)
  f.from, f.to, f.name, f.value, f.route = from, to, name, value, "to"
  if core.type(to) ~= "body" then core.fail("body:send wants a body to send to; got %s", core.type(to)) end
  post(from, "body:send", f)
  return from
end

local among = only("after", "layer", "kind")
core.declare("body:send_neighbours", { "Sends a message to all bodies it is linked with.", takes = named, fields = among, optional = true,
  gives = "body" })

-- body:send_neighbours(name, value, {kind=, layer=, after=}) -> body; static neighbours get it too
function body.send_neighbours(from, name, value, fields)
  local f = core.check(fields or {}, "body:send_neighbours", among)
  f.from, f.name, f.value, f.route = from, name, value, "neighbours"
  post(from, "body:send_neighbours", f)
  return from
end

local broadcasts = { from = { "body", "the body that sends it" }, after = spec.after }
core.declare("DIG:broadcast", { "Sends a message to every member, whoever that is when it is delivered.", takes = named,
  fields = broadcasts,
  optional = true, gives = "DIG" })

-- dig:broadcast(name, value, from | {from=, after=}) -> dig: to every member, whoever that is when it is delivered
function dig.broadcast(to, name, value, fields)
  if core.type(fields) == "body" then fields = { from = fields } end
  local f = core.check(fields or {}, "dig:broadcast", broadcasts)
  f.dig, f.name, f.value, f.route = to, name, value, "dig"
  post(to, "dig:broadcast", f)
  return to
end

-- ---- floods ----

local floods = only("after", "layer", "kind", "hops", "transform")
core.declare("body:flood",
  { "Sends a message outwards along the links; gives how many it reached, and a ring of links that contradicts itself.",
  takes = named, fields = floods, optional = true, gives = "integer, body[]?" })

-- The two ways to one body, up to where they part: a ring of links
local function ring(tree, one, other)
  local list = {}
  while one ~= other do
    if tree[one].hop >= tree[other].hop then
      list[#list + 1] = one
      one = tree[one].from
    else
      list[#list + 1] = other
      other = tree[other].from
    end
  end
  list[#list + 1] = one
  return core.list(list)
end

local function same(a, b) return math.abs(a - b) <= 1e-9 * (math.abs(a) + math.abs(b)) end

-- transform(value, hop, from, to) gives the value that arrives at `to`, nil: the link does not pass it
local function flood_by_function(start, name, value, f)
  local tree, order, values, loop = { [start] = { value = value, hop = 0 } }, { start }, {}, nil
  local kind = f.kind or f.layer ~= "mechanical" and f.layer or nil
  local layer = f.layer or kind ~= "contact" and kind ~= "joint" and kind or nil
  local i = 1
  while order[i] do
    local from = order[i]
    local at = tree[from]
    for _, to in ipairs((not f.hops or at.hop < f.hops) and from:neighbours(kind and { kind = kind } or nil) or {}) do
      local passes = to:dig_of(layer) ~= nil and to ~= at.from
      local arrives = passes and f.transform(at.value, at.hop + 1, from, to) or nil
      if arrives ~= nil and not tree[to] then
        tree[to] = { value = arrives, hop = at.hop + 1, from = from }
        order[#order + 1], values[#values + 1] = to, arrives
      elseif arrives ~= nil and not loop and type(arrives) == "number" and not same(arrives, tree[to].value) then
        loop = ring(tree, from, to)
      end
    end
    i = i + 1
  end
  table.remove(order, 1)
  core.post_list(start, "body:flood", { name = name }, order, values)
  return #order, loop
end

-- body:flood(name, value, {layer=, kind=, hops=, transform=, after=}) -> bodies reached, and the ring that contradicts itself or nil
-- Travels along the links, outwards from this body, to dynamic bodies (of another layer: to its members). transform: what a link does
-- to the value: a number multiplies it; "ratio" takes the ratio of gears, racks and links that have one, and only those pass; a
-- function(value, hop, from, to) gives what arrives, nil for nothing.
function body.flood(from, name, value, fields)
  local f = core.check(fields or {}, "body:flood", floods)
  if type(f.transform) == "function" then
    if f.after then core.fail "body:flood: with a function as transform it cannot be delayed; a number or 'ratio' can" end
    return flood_by_function(from, name, value, f)
  end
  f.from, f.name, f.value, f.route = from, name, value, "flood"
  return post(from, "body:flood", f)
end

return true
