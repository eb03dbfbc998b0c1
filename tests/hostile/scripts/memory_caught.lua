-- threat: memory errors are caught, over and over
-- expect: limit
while true do pcall(function() local t = {} for i = 1, math.huge do t[i] = ("m"):rep(2000) .. i end end) end
