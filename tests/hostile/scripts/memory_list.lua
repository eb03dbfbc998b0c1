-- threat: a list of lists without end
-- expect: limit
local t = {} while true do t = { t, t, {} } t[#t + 1] = { #t, t } end
