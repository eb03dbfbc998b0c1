-- threat: plain find that nearly matches everywhere
-- expect: limit
local text, what = ("a"):rep(2000000), ("a"):rep(20000) .. "b"
while true do text:find(what, 1, true) end
