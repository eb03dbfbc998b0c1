-- threat: upper and reverse of a long text in a loop
-- expect: limit
local text = ("a"):rep(1 << 23)
while true do local _ = text:upper():reverse() end
