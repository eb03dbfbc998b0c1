-- threat: nothing that reaches the machine is in reach
-- expect: ok
local bad = { "io", "os", "debug", "package", "dofile", "loadfile", "warn", "require", "module", "setfenv" }
for _, name in ipairs(bad) do assert(rawget(_G, name) == nil, name) end
for _, library in pairs(_G) do
  if type(library) == "table" then
    for _, name in ipairs { "dump", "execute", "getenv", "popen", "open", "sethook", "getregistry", "searchpath", "loadlib" } do
      assert(rawget(library, name) == nil, name)
    end
  end
end
print "fine"
