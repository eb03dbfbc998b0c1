-- threat: no address in any text
-- expect: ok
local co, f = coroutine.create(print), function() end
for _, v in ipairs { {}, f, co, print, string.gsub, setmetatable({}, { __name = "thing" }) } do
  assert(not tostring(v):find("0x") and not ("%s"):format(v):find("0x") and not ("%10.60s|"):format(v):find("0x"))
  assert(not pcall(string.format, "%p", v))
  local _, why = pcall(function() return v + 1 end) assert(not tostring(why):find("0x"))
end
print "fine"
