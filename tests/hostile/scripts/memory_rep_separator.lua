-- threat: sizes that overflow
-- expect: error
return ("ab"):rep(math.maxinteger, "separator")
