-- threat: every function with every kind of nonsense
-- expect: ok
local values = { 0, -1, math.maxinteger, math.mininteger, 0 / 0, 1 / 0, 0.5, "", "%", "[", "%b", "(", "\0", {}, print, true, ("s"):rep(99) }
local heavy = { rep = true, move = true, concat = true, unpack = true, insert = true, remove = true, pack = true }
for _, library in ipairs { string, math, utf8, table } do
  for name, f in pairs(library) do
    if type(f) == "function" and not heavy[name] then
      for _, a in ipairs(values) do
        pcall(f, a)
        for _, b in ipairs(values) do pcall(f, a, b) for _, c in ipairs { 0, -1, math.mininteger, "%1", {} } do pcall(f, a, b, c) end end
      end
    end
  end
end
print "fine"
