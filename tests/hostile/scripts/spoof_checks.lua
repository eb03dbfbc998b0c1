-- threat: a script that takes the checks away
-- expect: any
assert, error, pcall = print, print, print
print(pcall(error, "nothing"))
