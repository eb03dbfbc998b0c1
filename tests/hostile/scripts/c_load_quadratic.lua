-- threat: source that the compiler takes quadratic time for: a chain of `or` is walked from its start at each link
-- expect: limit
load("return " .. ("a or "):rep(8e5) .. "a")
while true do load("return " .. ("a and "):rep(1e5) .. "a") end
