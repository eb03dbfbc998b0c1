-- threat: string.format with widths, precisions and counts that its buffers do not have
-- expect: ok
for _, f in ipairs { "%99999d", "%.99999f", "%0100d", "%1000000000s", "%-+ #0999d", "%.f%.%", "%ll", "%n", "%*d", "%$", "%5$d", "%", "%.100s" } do
  pcall(string.format, f, 1, 2, 3)
end
assert(#("%99.99f"):format(-1e308) > 300 and #("%.99f"):format(5e-324) == 101 and #("%99d"):format(1) == 99)
for _, c in ipairs { "d", "i", "u", "c", "x", "X", "o", "a", "A", "e", "E", "f", "F", "g", "G", "p", "q", "s" } do
  for _, v in ipairs { 0 / 0, 1 / 0, math.mininteger, -0.0, 1e308, "x", {}, print, true, "9" } do
    local fine, text = pcall(string.format, "%" .. c, v)
    assert(not fine or not text:find "0x%x%x%x%x%x%x%x%x%x" or type(v) ~= "table" and type(v) ~= "function", text)
    pcall(string.format, "%99.99" .. c, v)
  end
end
assert(not pcall(string.format, ("%d"):rep(1e5)))
assert(#string.format(("%%"):rep(1e5)) == 1e5)
print "fine"
