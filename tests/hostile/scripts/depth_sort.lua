-- threat: comparisons that sort
-- expect: error
local function less() table.sort({ 2, 1 }, less) end
less()
