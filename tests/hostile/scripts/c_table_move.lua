-- threat: table.move over slots that do not exist
-- expect: limit
table.move({}, 1, math.maxinteger - 1, 2, {})
