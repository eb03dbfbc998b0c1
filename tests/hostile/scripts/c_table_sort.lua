-- threat: table.sort of a list that lies about its length
-- expect: limit
table.sort(setmetatable({}, { __len = function() return 2 ^ 30 // 1 | 0 end, __index = function() return 1 end }))
