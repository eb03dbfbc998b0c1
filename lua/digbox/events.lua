-- digbox/events.lua - world:on, body:on, and delivery after the step.
--
-- Order: events as the engine lists them (time, kind, lower slot, higher slot); for one event, handlers in the order they were
-- added. Each handler gets a copy of its own. Anything may be created or removed in a handler; the world cannot be stepped there.

local core = ...
local next, type, error = next, type, error

local kinds = core.event_kinds

-- ---- subscriptions ----

local Subscription = {}
Subscription.__index = function(_, key)
  local method = Subscription[key]
  if not method then core.unknown("subscription", "has no field or method", tostring(key), { off = true }) end
  return method
end
Subscription.__metatable = false
Subscription.__name = "subscription"
local make_subscription, open_subscription = core.opaque(Subscription)

core.declare_type("subscription", "A handler that waits for events.", Subscription)
core.declare("subscription:off", { "No more calls." })

-- sub:off(): no more calls
function Subscription.off(handle)
  local sub = open_subscription(handle)
  sub.active = false
  sub.book.stale = true
end

local function book_of(world, state, kind)
  local book = state.handlers[kind]
  if not book then
    book = { everyone = {}, by_body = {}, stale = false }
    state.handlers[kind] = book
    state.mask = state.mask | (1 << kinds[kind])
    core.quiet(world)
    if kind == "moved" then core.tell_moves(world) end
  end
  return book
end

local filter_fields = {
  with = { "any", "only with this body, or one of these; a name: the body that has it now",
    type = "body|room|string|(body|room|string)[]" },
  faster_than = { "real m/s", "only when they close faster" }, harder_than = { "real N*s", "only when the blow is harder" },
  wall = { "text", "only with this wall of the room", of = { "+x", "-x", "+y", "-y", "+z", "-z" } },
  kind = { "text", "of a link: only of that kind; of a message: only with that name" },
  region = { "any", "only of that region", type = "region" }, layer = { "text", "of links and DIGs: of that layer, or any" } }
local on_takes = { { "event", "text", "name of the event", of = kinds },
  { "handler", "function", "called with a copy of the event, after the step" } }
core.declare("world:on", { "Calls a function at every event of a kind.", takes = on_takes, fields = filter_fields, filter = true,
  gives = "subscription" })
core.declare("body:on", { "Calls a function at every event of a kind that this body takes part in; it is `self` in the event.",
  takes = on_takes, fields = filter_fields, filter = true, gives = "subscription" })

-- The body itself, or the one that has that name now; or the room.
local function body_called(world, what, given)
  if core.is_room(given) then return given end
  local body = given
  if type(given) == "string" then
    body = world:find(given)
    if core.type(body) ~= "body" then core.fail("%s: there is no body '%s'", what, given) end
  end
  if core.type(body) ~= "body" then core.fail("%s wants a body; got %s", what, core.type(body)) end
  return body
end

local function read_filter(filter, what, world)
  if filter == nil then return nil end
  local f = core.check(filter, what, filter_fields)
  if type(f.with) == "string" or core.type(f.with) == "body" or core.is_room(f.with) then
    f.with = { body_called(world, what .. ".with", f.with) }
  elseif f.with ~= nil then
    if type(f.with) ~= "table" then core.fail("%s.with wants a body, a room or a list of bodies; got %s", what, core.type(f.with)) end
    local bodies = {}
    for i, b in ipairs(f.with) do bodies[i] = body_called(world, ("%s.with[%d]"):format(what, i), b) end
    f.with = bodies
  end
  if f.region ~= nil and core.type(f.region) ~= "region" then
    core.fail("%s.region wants a region; got %s", what, core.type(f.region))
  end
  return f
end

local function subscribe(world, body, what, kind, filter, fn)
  if type(kind) ~= "string" then core.fail("%s wants the name of an event; got %s", what, core.type(kind)) end
  if not kinds[kind] then core.unknown(what .. ":", "unknown event", kind, kinds) end
  if fn == nil and (type(filter) == "function" or core.type(filter) ~= "table") then filter, fn = nil, filter end
  if type(fn) ~= "function" then core.fail("%s('%s') wants a function; got %s", what, kind, core.type(fn)) end
  local state = core.lua_state(world)
  local book = book_of(world, state, kind)
  state.subscriptions = state.subscriptions + 1
  local sub = { id = state.subscriptions, fn = fn, body = body, world = world, kind = kind, active = true, book = book,
    filter = read_filter(filter, what, world) }
  local list = book.everyone
  if body then
    list = book.by_body[body] or {}
    book.by_body[body] = list
  end
  list[#list + 1] = sub
  return make_subscription(sub)
end

-- world:on(event, [filter], fn) -> subscription with :off()
function core.types.world.methods.on(world, kind, filter, fn)
  return subscribe(world, nil, "world:on", kind, filter, fn)
end

-- body:on(event, [filter], fn) -> subscription; in the event, self is this body and other the one it met
function core.types.body.methods.on(body, kind, filter, fn)
  return subscribe(body.world, body, "body:on", kind, filter, fn)
end

-- ---- delivery ----

-- Changes of other layers than the mechanical one are told to those who ask for them: { layer = "thermal" }, { kind = "thermal" } or
-- { layer = "any" }.
local function of_layer(f, e)
  local wanted = f and f.layer
  if not wanted and f and f.kind then return true end
  return wanted == "any" or e.layer == (wanted or "mechanical")
end

local function accepts(f, e)
  if e.layer and not of_layer(f, e) then return false end
  if not f then return true end
  if f.faster_than and e.speed <= f.faster_than then return false end
  if f.harder_than and e.impulse <= f.harder_than then return false end
  if f.region and e.region ~= f.region then return false end
  if f.wall and e.wall ~= f.wall then return false end
  if f.kind and e.kind ~= f.kind then return false end
  if not f.with then return true end
  for _, b in ipairs(f.with) do
    if b == e.other or (e.from and (b == e.from or b == e.to)) then return true end
  end
  return false
end

local function copy_for(e, body, world)
  local copy = {}
  for k, v in next, e do copy[k] = v end
  if body and e.other_dig then                              -- of DIGs, whose members all take part
    copy.self = body
  elseif e.b and (body == e.b or e.wall) then                   -- a wall of the room is no body: it is never self
    copy.self, copy.other, copy.normal = e.b, e.a, -e.normal
  else
    copy.self, copy.other = e.a, e.b
  end
  if e.wall then copy.other = core.room_of(world) end
  return copy
end

local function add_all(to, from)
  for _, sub in ipairs(from or {}) do to[#to + 1] = sub end
end

-- DIGs merged or split: who is in one of them now.
local function add_members(list, book, e)
  for body, subs in next, book.by_body do
    local dig = body.valid and body:dig_of(e.layer)
    if dig and (dig == e.dig or dig == e.other_dig) then add_all(list, subs) end
  end
end

-- Handlers of one event in the order they were added.
local function handlers_for(book, e)
  local list = {}
  add_all(list, book.everyone)
  if next(book.by_body) then
    if e.a then add_all(list, book.by_body[e.a]) end
    if e.event == "merged" or e.event == "split" then add_members(list, book, e) end
    if e.event ~= "message" and e.b and e.b ~= e.a then add_all(list, book.by_body[e.b]) end
    if #list > 1 then table.sort(list, function(p, q) return p.id < q.id end) end
  end
  return list
end

local function sweep(list)
  local kept = {}
  for _, sub in ipairs(list) do
    if sub.active then kept[#kept + 1] = sub end
  end
  return kept
end

local function drop_stale(book)
  book.stale = false
  book.everyone = sweep(book.everyone)
  for body, list in next, book.by_body do
    local kept = sweep(list)
    book.by_body[body] = #kept > 0 and kept or nil
  end
end

local delivering                 -- the Lua side of the world whose events are being delivered

-- Two handlers of one step may both remove a body that was hit twice: the second has nothing to do any more, and is no mistake. One that
-- removes it twice itself makes one.
local remove = core.types.body.methods.remove
function core.types.body.methods.remove(body)
  local gone = delivering and delivering.gone
  if not gone then return remove(body) end
  if not gone[body] or gone[body] == delivering.calls or body.valid then
    remove(body)
    gone[body] = delivering.calls
  elseif not delivering.removed_twice and not core.options.quiet then
    delivering.removed_twice = true
    local name = tostring(body):gsub("^removed ", "")
    core.tell(("digbox: %s%s was removed already, by an earlier handler of this step\n"):format(core.where(), name))
  end
end

local function who(e)
  local a, b = e.a or e.from, e.b or e.to
  if e.wall then a, b = a or b, "wall " .. e.wall end
  return a and " of " .. tostring(a) .. (b and " and " .. tostring(b) or "") or ""
end

-- What handlers get is a copy; a name that no event has is a mistake, such as that of a handler that takes the other body for it.
local event_meta = { __metatable = false, __index = function(_, key)
  local known = core.declared.types.event.properties
  if type(key) == "string" and not known[key] then core.unknown("event", "has no field", key, known) end
end }

local function call(state, sub, e)
  state.in_handler, state.calls = sub.kind, (state.calls or 0) + 1
  local ok, message = core.call(sub.fn, setmetatable(copy_for(e, sub.body, sub.world), event_meta))
  state.in_handler = nil
  if ok then
    if message == true and e.event == "disabled" then core.forgive(e.a) end
    return
  end
  core.answering(sub.world)
  if type(message) == "string" then
    local steps = core.is_open(sub.world) and (", step %d"):format(sub.world.steps) or ""
    message = ("%s (in a handler of '%s' at t = %.6g s%s%s)"):format(message, sub.kind, e.time, steps, who(e))
  end
  delivering = nil
  error(message, 0)
end

-- Keeps the last events as text, for the reports of failed scenarios.
local function remember(state, events)
  local log = state.event_log
  for _, e in ipairs(events) do
    local others = (e.b and " " .. tostring(e.b) or "") .. (e.wall and " wall " .. e.wall or "")
    log[#log + 1] = ("t = %.4f s  %-13s %s%s%s"):format(e.time, e.event, e.a and tostring(e.a) or "", others,
      e.speed and e.speed > 0 and ("  %.4g m/s"):format(e.speed) or "")
  end
  if #log > 60 then
    state.event_log = table.move(log, #log - 29, #log, 1, {})
  end
end

local function tell(world, state, book, e)
  if e.event == "message" then
    if not e.to or not e.to.valid then return core.message_dropped(world) end      -- an earlier handler removed it
    core.answering(world, e.root)
  end
  for _, sub in ipairs(handlers_for(book, e)) do
    if sub.active and accepts(sub.filter, copy_for(e, sub.body, world)) then call(state, sub, e) end
  end
  if e.event == "message" then core.answering(world) end
  if book.stale then drop_stale(book) end
end

-- Called once after each step. What handlers send without delay belongs to the same instant: its handlers are called too, until no
-- more is sent. A cascade that does not end is a storm, which is an error (engine/api/message.c).
function core.deliver(world, state)
  local mask = state.mask | (state.log_mask or 0)
  if mask == 0 then return end
  local events, outer = core.events(world, mask), delivering
  delivering, state.gone = state, {}
  while #events > 0 do
    if state.log_mask then remember(state, events) end
    for _, e in ipairs(events) do
      local book = state.handlers[e.event]
      if book then tell(world, state, book, e) end
    end
    events = mask >> kinds.message & 1 == 1 and core.events(world, mask, core.take_messages(world)) or {}
  end
  delivering, state.gone = outer, nil
end

-- The Lua side of a world, made on first use.
function core.lua_state(world)
  local state = core.state(world)
  if not state.handlers then
    state.handlers, state.mask, state.subscriptions = {}, 0, 0
    state.tasks, state.films, state.scene, state.event_log, state.forces, state.warnings = {}, {}, { lamps = {} }, {}, {}, 0
  end
  return state
end

-- -> the Lua side of the world
function core.forbid_in_handler(world, what)
  local state = core.lua_state(world)
  if state.in_handler then core.fail("%s cannot be called inside a handler of '%s'", what, state.in_handler) end
  if state.in_task then core.fail("%s cannot be called inside a task", what) end
  return state
end

return true
