-- threat: a message that pretends to be something else
-- expect: error
error("secret.lua:1: \27[2J\27]0;title\7\27[32mall tests passed\27[0m\n42 passed, 0 failed\0\b\b\r", 0)
