-- threat: require stays in the script's folder
-- expect: ok
for _, name in ipairs { "../x", "/etc/passwd", "a\0b", "..", ".", "", "a/b", "~", ("m"):rep(5000), "x.y.z", "\n" } do assert(not pcall(require, name)) end
print "fine"
