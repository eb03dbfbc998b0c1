-- threat: an error object whose text never comes
-- expect: error
error(setmetatable({}, { __tostring = function() while true do end end, __name = 5, __concat = error }))
