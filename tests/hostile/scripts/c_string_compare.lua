-- threat: each comparison takes a millisecond
-- expect: limit
local a, b = ("z"):rep(1 << 23), ("z"):rep((1 << 23) - 1) .. "z"
local n = 0
while true do if a <= b and a ~= b then n = n + 1 end end
