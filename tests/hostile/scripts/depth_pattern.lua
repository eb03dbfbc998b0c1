-- threat: long patterns, many captures, many choices
-- expect: ok
print(pcall(string.find, "x", ("(x)"):rep(100))) print(pcall(string.gsub, ("a"):rep(1e5), ("a?"):rep(1e5), ""))
print((("a"):rep(1e6)):find(("a"):rep(1e5)) ~= nil)
print "fine"
