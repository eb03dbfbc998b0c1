-- threat: compiled chunks are refused in every way
-- expect: ok
local chunk = "\27Lua\x54\0\x19\x93\r\n\x1a\n\4\8\8" .. ("\0"):rep(60)
for _, mode in ipairs { "b", "bt", "t", "tb" } do assert(not load(chunk, "=c", mode)) end
local sent
assert(not load(function() if not sent then sent = true return chunk end end, "=c", "b"))
print "fine"
