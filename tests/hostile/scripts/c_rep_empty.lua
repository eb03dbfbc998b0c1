-- threat: string.rep of nothing, as often as can be asked for
-- expect: ok
assert(("") :rep(math.maxinteger) == "" and (""):rep(1 << 40, "") == "")
print "fine"
