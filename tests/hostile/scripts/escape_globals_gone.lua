-- threat: everything is taken away before the error
-- expect: error
local raise = error
local names = {}
for name in pairs(_G) do names[#names + 1] = name end
for _, name in ipairs(names) do _G[name] = nil end
raise "the true message"
