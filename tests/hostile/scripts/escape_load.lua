-- threat: load and require as ways out: names that pass for files, environments, readers that change their minds, modules of the program
-- expect: ok
local f = load("return ...", "@/etc/passwd", "b", {})
assert(f and f(5) == 5)
assert(load("\27Lua", "x", "bt") == nil and load(function() return "\27Lua" end) == nil)
local given = 0
assert(load(function() given = given + 1 return given == 1 and "\27" or given == 2 and "Lua" or nil end) == nil)
assert(not pcall(load, function() return {} end) and not pcall(load, {}, 5, {}, {}))
local env = setmetatable({}, { __index = function(_, k) return rawget(_G, k) end })
assert(load("return io, os, debug, package, dofile, loadfile, collectgarbage and collectgarbage 'stop'", "x", "t", env) ~= nil)
for _, name in ipairs { "io", "os", "debug", "package", "dofile", "loadfile", "ffi", "jit", "newproxy", "module", "setfenv", "getfenv" } do
  assert(load("return " .. name)() == nil and env[name] == nil, name)
end
for _, name in ipairs { "digbox.core", "digbox.sandbox", "digbox.init", "digbox.run", "io", "os", "debug", "package", "_G", "..", "...", "", ".", "/",
  "/etc/passwd", "../up", "a/../../up", "a\0b", "out/../../x", "~", ("a/"):rep(5e4), ("x"):rep(1e6), "\27", "a.b.c" } do
  local fine, it = pcall(require, name)
  assert(not fine, name:sub(1, 20) .. ": " .. tostring(it))
end
assert(require "digbox" == require "digbox")
for _, m in ipairs { require "digbox", require "digbox.test" } do
  pcall(function() m.new_field = 1 end) pcall(rawset, m, "load", print) pcall(setmetatable, m, nil)
end
assert(getmetatable "" == false and string.dump == nil)
print "fine"
