-- threat: table.remove from a list that lies about its length
-- expect: limit
table.remove(setmetatable({}, { __len = function() return math.maxinteger - 1 end }), 1)
