-- threat: patterns over a long text, again and again
-- expect: limit
local text = (" "):rep(4000000)
while true do text:find("%f[%a]%a-%f[%A]$") end
