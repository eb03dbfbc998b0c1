-- threat: a pattern with exponentially many ways
-- expect: limit
local text = ("ab"):rep(30)
return text:match(("[ab]*"):rep(24) .. "c")
