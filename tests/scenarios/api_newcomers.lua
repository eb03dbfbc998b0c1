-- api_newcomers.lua: what somebody writes who knows other programs and the first page: it works, or the error says what to write.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- The message without its position, and the position's line.
local function message_of(fn)
  local text = expect(fn):fails()
  local line, rest = text:match "^[^:]*api_newcomers%.lua:(%d+): (.*)$"
  expect(line):is_not(nil)
  return rest or text, tonumber(line)
end

local function says(fn, wanted)
  expect((message_of(fn))):is(wanted)
end

-- A tail call gives up the frame of who makes it; functions in C leave it, so ours that are written in Lua are called through one.
scenario("an error after a tail call names the line of the call", function(s)
  local world = s.world
  local ball = world:ball { radius = 0.1, at = { 0, 1, 0 } }
  local base = select(2, message_of(function() error "here" end))
  local calls = {
    function() return error "own" end,
    function() return world:ball { raduis = 1 } end,
    function() return world:record { too = "x" } end,
    function() return ball:on("contact_begni", print) end,
    function() return digbox.load(3) end,
    function() return digbox.parts.clock { hours = 1 } end,
    function() return digbox.material "cork" end,
    function() return string.format("%d", "x") end,
    function() return ("%d"):format "x" end,
    function() return string.pack("i17", 1) end,
    function() return utf8.codepoint("abc", 9) end,
    function() return tonumber("z", 99) end,
    function() return setmetatable(1, {}) end,
  }
  for i, call in ipairs(calls) do
    local text, line = message_of(function() call() end)
    if line ~= base + 1 + i then expect(text):is("line " .. base + 1 + i .. ", not " .. line) end
  end
  says(function() return string.format("%d", 1.5) end, "bad argument #2 to 'format' (number has no integer representation)")
  says(function() return ("%d"):format(1.5) end, "bad argument #1 to 'format' (number has no integer representation)")
  says(function() return utf8.codepoint("abc", 9) end, "bad argument #3 to 'codepoint' (out of bounds)")
end)

scenario("what a method of ours waits for may be waited for after a tail call, too", function(s)
  local times = {}
  s.world:spawn(function(task)
    local function pause() return task:wait "0.1 s" end
    pause()
    times[#times + 1] = s.world.time
    return task:wait(0.1)
  end)
  s.world:run(0.5)
  expect(times[1]):near(0.1, 1e-9)
  expect(s.world.tasks):is(0)
end)
