-- threat: printing without end
-- expect: any
while true do print(("noise"):rep(300)) end
