-- threat: lengths of a long text in a loop
-- expect: limit
local text = ("\u{20AC}"):rep(2000000)
while true do utf8.len(text) end
