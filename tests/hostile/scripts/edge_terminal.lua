-- threat: what is printed clears the screen, sets the title and asks the terminal to type
-- expect: ok
print "\27[2J\27[H\27]0;all tests passed\7\27[c\27P+q544e\27\\\u{9b}31mred"
print(("\8"):rep(100) .. "\r1 passed, 0 failed", "\0\1\2\127\u{80}\u{9f}")
print "fine"
