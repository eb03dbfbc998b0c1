-- threat: table.unpack of more than fits
-- expect: any
print(pcall(table.unpack, {}, 1, 1e7)) print(pcall(table.unpack, {}, math.mininteger, math.maxinteger))
print "fine"
