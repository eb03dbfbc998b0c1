-- threat: source that is nested deeper than can be compiled
-- expect: ok
for _, text in ipairs { ("["):rep(1e5), ("return function() "):rep(1e4), "x = " .. ("{a="):rep(1e5), "return " .. ("#"):rep(1e5) .. "x",
  ("while x do "):rep(1e5), "return x" .. ("[1]"):rep(1e5), "goto " .. ("l"):rep(1e6) } do
  local _, f, why = pcall(load, text) assert(type(f) == "function" or why)
end
print "fine"
