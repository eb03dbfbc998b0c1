-- threat: replacements that replace
-- expect: error
local function by() return (("x"):gsub("x", by)) end
by()
