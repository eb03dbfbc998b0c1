-- threat: every character becomes a megabyte
-- expect: limit
return #(("g"):rep(1 << 20):gsub(".", ("G"):rep(1 << 20)))
