-- threat: a loop that never ends, of the other kind
-- expect: limit
repeat local x = 1 until x == 2
