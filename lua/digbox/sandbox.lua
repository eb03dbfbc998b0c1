-- digbox/sandbox.lua - what differs from plain Lua inside the program: pairs in a fixed order, random numbers from a fixed seed.

local core = ...
local globals = core.globals
local raw_pairs, raw_next, type, sort = pairs, next, type, table.sort
local metatable_of, rawget = getmetatable, rawget
local raw_seed = math.randomseed

raw_seed(1)

-- math.randomseed() without a number would take the clock: it takes 1.
function globals.math.randomseed(...)
  if select("#", ...) == 0 then return raw_seed(1) end
  return raw_seed(...)
end

-- Lua hashes strings with a seed that differs between runs, so next visits them in another order each time. pairs visits whole
-- numbers and numbers first, in order, then strings in order, then other keys as next has them.
local rank = { number = 1, string = 2 }

local function before(a, b)
  local p, q = rank[type(a)], rank[type(b)]
  if p ~= q then return p < q end
  return a < b
end

local function ordered_keys(t)
  local keys, others, strings = {}, {}, false
  for k in raw_next, t do
    local kind = rank[type(k)]
    if not kind then
      others[#others + 1] = k
    else
      keys[#keys + 1] = k
      strings = strings or kind == 2
    end
  end
  if not strings then return nil end       -- numbers alone come in a fixed order anyway
  sort(keys, before)
  for _, k in ipairs(others) do keys[#keys + 1] = k end
  return keys
end

function globals.pairs(t)
  if type(t) ~= "table" then return raw_pairs(t) end
  local meta = metatable_of(t)
  if type(meta) == "table" and rawget(meta, "__pairs") then return raw_pairs(t) end
  local keys = ordered_keys(t)
  if not keys then return raw_next, t, nil end
  local i = 0
  return function()
    repeat
      i = i + 1
      local k = keys[i]
      if k == nil then return nil end
      local v = rawget(t, k)
      if v ~= nil then return k, v end
    until false
  end, t, nil
end

return true
