-- threat: load with a reader that never comes to its end
-- expect: limit
while true do load(function() return "--" end) end
