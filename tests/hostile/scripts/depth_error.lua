-- threat: errors in handlers of errors
-- expect: any
print(xpcall(error, function(m) error(m) end, "x")) print(xpcall(error, error, setmetatable({}, { __tostring = error })))
local function h(m) return h(m .. m) .. m end print(xpcall(error, h, "y"))
