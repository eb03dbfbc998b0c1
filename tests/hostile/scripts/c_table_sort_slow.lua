-- threat: table.sort with a comparison that never returns
-- expect: limit
table.sort({ 3, 1, 2 }, function() while true do end end)
