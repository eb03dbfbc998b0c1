-- threat: a long text printed into itself
-- expect: limit
local s = ("f"):rep(1 << 20) while true do s = ("%s%s"):format(s, s) end
