-- threat: %b at each of four million places
-- expect: limit
return (("{"):rep(4000000)):match("%b{}")
