-- threat: gsub that replaces a million empty matches, in a loop
-- expect: limit
local text = ("q"):rep(1000000)
while true do text:gsub("()", "%1") end
