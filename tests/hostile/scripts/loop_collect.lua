-- threat: work for the collector without end
-- expect: limit
local live = {}
for i = 1, 50000 do live[i] = { i } end
while true do local _ = { {}, {}, {} } pcall(collectgarbage, "step") end
