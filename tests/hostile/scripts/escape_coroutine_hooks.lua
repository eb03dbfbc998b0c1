-- threat: coroutine functions take coroutines only
-- expect: ok
for name, f in pairs(coroutine) do
  if name ~= "running" and name ~= "isyieldable" and name ~= "yield" then assert(not pcall(f, 5), name) assert(not pcall(f), name) end
end
assert(not pcall(coroutine.close, (coroutine.running())))
print "fine"
