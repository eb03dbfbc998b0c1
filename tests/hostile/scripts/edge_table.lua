-- threat: table functions at the ends of the integers
-- expect: ok
local I, N = math.maxinteger, math.mininteger
print(pcall(table.insert, {}, I, 1)) print(pcall(table.insert, {}, 0, 1)) print(pcall(table.insert, {}, 1, 2, 3)) print(pcall(table.insert, {}))
print(pcall(table.remove, {}, 5)) print(pcall(table.remove, { 1 }, 3)) print(table.remove({}, 0)) print(table.remove({ 7 }))
print(pcall(table.move, {}, N, I, 1)) print(pcall(table.move, {}, 1, 2, I)) print(#table.move({ 1, 2, 3 }, 1, 3, 2))
print(table.concat({ 1, 2 }, ",", 1, 2), pcall(table.concat, { {} }), table.concat({}, "x", I, I - 1), pcall(table.concat, {}, "", I, I))
print(table.unpack({ 1, 2, 3 }, -1, 1)) print(table.unpack({}, I, I)) print(select("#", table.unpack({}, 1, 0)))
print "fine"
