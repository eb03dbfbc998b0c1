-- threat: the source of a large table
-- expect: any
print(load("return { " .. ("{},"):rep(1000000) .. "}"))
