-- threat: a handler of errors that itself never ends
-- expect: limit
xpcall(function() repeat until false end, function(m) repeat m = m .. "" until false end)
