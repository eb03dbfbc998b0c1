-- threat: the same for an error of the script's own
-- expect: limit
xpcall(error, function() while true do end end, "go")
