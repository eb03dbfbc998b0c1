-- threat: one call that asks for a terabyte
-- expect: limit
return #("ab"):rep(1 << 39)
