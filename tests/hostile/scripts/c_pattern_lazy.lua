-- threat: lazy repetitions, polynomial of a high degree
-- expect: limit
return (("y"):rep(3000)):find((".-"):rep(40) .. "z")
