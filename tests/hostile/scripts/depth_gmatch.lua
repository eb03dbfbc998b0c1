-- threat: an iterator that is asked again after it failed (Lua of every release runs off its stack)
-- expect: ok
local again = (("b"):rep(300000)):gmatch(("b-"):rep(300000))
for _ = 1, 4 do print(pcall(again)) end
print "fine"
